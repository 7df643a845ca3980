//! Groom presets that are part of the program: `presets/*.toml`, with the tables `guard`,
//! `undercoat` and `base`. The first line of a file is a comment that describes the fur; the next
//! ones name the source of its numbers.

const PRESETS: &[(&str, &str)] = &[
    ("arctic_fox", include_str!("../../../../presets/arctic_fox.toml")),
    ("black_cat", include_str!("../../../../presets/black_cat.toml")),
    ("brown_mink", include_str!("../../../../presets/brown_mink.toml")),
    ("polar_bear", include_str!("../../../../presets/polar_bear.toml")),
    ("rabbit", include_str!("../../../../presets/rabbit.toml")),
    ("raccoon", include_str!("../../../../presets/raccoon.toml")),
    ("red_fox", include_str!("../../../../presets/red_fox.toml")),
    ("wolf", include_str!("../../../../presets/wolf.toml")),
];

/// The names of all presets, sorted.
pub fn names() -> impl Iterator<Item = &'static str> {
    PRESETS.iter().map(|(name, _)| *name)
}

/// The TOML text of a preset.
pub fn text(name: &str) -> Option<&'static str> {
    PRESETS.iter().find(|(n, _)| *n == name).map(|(_, text)| *text)
}

/// What a preset is: the first line of its file.
pub fn about(name: &str) -> Option<&'static str> {
    text(name)?.lines().next()?.strip_prefix("# ")
}
