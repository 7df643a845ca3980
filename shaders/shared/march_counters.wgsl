// Words of the buffer `march_counters`.

const RAYS_LOST: u32 = 0u;
const LONGEST_LIST: u32 = 1u;
const FRAGMENTS_LISTED: u32 = 2u;   // in the lists that `resolve` walked
const FRAGMENTS_UNREAD: u32 = 3u;   // of those, not reached before the adapter ended the loops
const RAYS_CUT: u32 = 4u;           // rays of `resolve` whose loops the adapter ended
const LIGHT_PATHS_CUT: u32 = 5u;    // nested marches towards a light that reached their last step
const MARCHES_CUT: u32 = 6u;        // rays of `undercoat_march` whose loops the adapter ended
