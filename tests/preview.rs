//! Pictures shown while they are rendered: refreshed files, and packets for the viewer tev.

use crate::common::{Folder, command, pelage};
use pelage_core::film::tev::Tev;
use pelage_core::film::{Film, io};
use std::io::Read;
use std::net::TcpListener;
use std::thread;
use std::time::{Duration, Instant};

/// What a viewer understood of a connection.
#[derive(Debug, PartialEq)]
enum Packet {
    Create { name: String, size: [u32; 2], channels: Vec<String> },
    Update { name: String, channels: Vec<String>, at: [u32; 2], size: [u32; 2], pixels: Vec<f32> },
}

/// Reads text up to its zero byte, and numbers, from the front of a packet.
struct Front<'a>(&'a [u8]);

impl Front<'_> {
    fn u32(&mut self) -> u32 {
        let (number, rest) = self.0.split_first_chunk().expect("a number");
        self.0 = rest;
        u32::from_le_bytes(*number)
    }

    fn text(&mut self) -> String {
        let end = self.0.iter().position(|b| *b == 0).expect("the end of a text");
        let text = String::from_utf8(self.0[..end].to_vec()).expect("UTF-8");
        self.0 = &self.0[end + 1..];
        text
    }

    fn channels(&mut self) -> Vec<String> {
        (0..self.u32()).map(|_| self.text()).collect()
    }
}

/// Decodes everything that is sent over a connection.
fn decode(bytes: &[u8]) -> Vec<Packet> {
    let mut packets = Vec::new();
    let mut rest = bytes;
    while !rest.is_empty() {
        let length = Front(rest).u32() as usize;
        let (packet, more) = rest.split_at(length);
        rest = more;
        assert_eq!(packet[5], 0, "the viewer's focus is not grabbed");
        let mut front = Front(&packet[6..]);
        let name = front.text();
        packets.push(match packet[4] {
            4 => {
                let size = [front.u32(), front.u32()];
                let channels = front.channels();
                assert!(front.0.is_empty());
                Packet::Create { name, size, channels }
            }
            5 => {
                let channels = front.channels();
                let at = [front.u32(), front.u32()];
                let size = [front.u32(), front.u32()];
                let pixels: Vec<f32> =
                    front.0.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
                assert_eq!(pixels.len(), channels.len() * (size[0] * size[1]) as usize);
                Packet::Update { name, channels, at, size, pixels }
            }
            other => panic!("operation {other}"),
        });
    }
    packets
}

/// A viewer that reads one connection to its end.
fn viewer() -> (String, thread::JoinHandle<Vec<Packet>>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let reader = thread::spawn(move || {
        let mut bytes = Vec::new();
        listener.accept().unwrap().0.read_to_end(&mut bytes).unwrap();
        decode(&bytes)
    });
    (address, reader)
}

#[test]
fn pictures_arrive_in_the_viewer() {
    let (address, reader) = viewer();
    // More rows than one packet takes.
    let (width, height) = (700, 500);
    let pixels: Vec<[f32; 4]> = (0..width * height).map(|i| [i as f32, 0.5, -1.0, 1.0]).collect();
    let film = Film::from_premultiplied(width, height, &pixels);
    let mut tev = Tev::connect(&address, "a \u{e4}.png").unwrap();
    tev.show(&film).unwrap();
    tev.show(&film).unwrap();
    drop(tev);
    let packets = reader.join().unwrap();
    let channels: Vec<String> = ["R", "G", "B", "A"].map(String::from).into();
    let name = "a \u{e4}.png".to_owned();
    assert_eq!(
        packets[0],
        Packet::Create { name: name.clone(), size: [width, height], channels: channels.clone() }
    );
    let mut shown = vec![[0.0; 4]; pixels.len()];
    let mut rows = 0;
    for packet in &packets[1..] {
        let Packet::Update { name: of, channels: named, at, size, pixels } = packet else {
            panic!("the image is made twice")
        };
        assert_eq!((of, named, at[0], size[0]), (&name, &channels, 0, width));
        rows += size[1];
        let count = (size[0] * size[1]) as usize;
        let first = (at[1] * width) as usize;
        for (i, pixel) in shown[first..first + count].iter_mut().enumerate() {
            *pixel = [0, 1, 2, 3].map(|c| pixels[c * count + i]);
        }
    }
    assert!(packets.len() > 3 && rows == 2 * height, "{} packets, {rows} rows", packets.len());
    assert_eq!(shown, pixels);
}

#[test]
fn a_missing_viewer_is_reported_before_rendering() {
    // A port that was free a moment ago.
    let address = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let folder = Folder::new();
    let (path, tev) = (folder.at("a.png"), format!("--tev={address}"));
    let started = Instant::now();
    pelage(&["render", "tests/data/small.toml", "-o", &path, &tev]).expect(1, &[&address, "start tev"]);
    assert!(started.elapsed() < Duration::from_secs(20) && !std::path::Path::new(&path).exists());
}

#[test]
fn the_finished_picture_arrives_in_the_viewer() {
    if crate::common::gpu::open().is_none() {
        return;
    }
    let (address, reader) = viewer();
    let folder = Folder::new();
    let (png, exr) = (folder.at("a.png"), folder.at("a.exr"));
    let tev = format!("--tev={address}");
    pelage(&["render", "tests/data/small.toml", "-o", &png, "-o", &exr, &tev]).expect(0, &[]);
    let packets = reader.join().unwrap();
    let Some(Packet::Update { name, pixels, .. }) = packets.last() else { panic!("{packets:?}") };
    assert_eq!(name, "a.png");
    let film = io::read(&exr).unwrap();
    let red = film.plane("R").unwrap();
    // Half floats in the file.
    assert!(red.iter().zip(pixels).all(|(a, b)| (a - b).abs() < 1e-3 * (1.0 + b.abs())));
    assert!(red.iter().any(|v| *v > 0.01));
}

/// A slow picture of many tiles: its file appears while it is rendered, whole at any time, and is
/// the same in the end as without previews.
#[test]
fn the_file_is_refreshed_while_rendering() {
    if crate::common::gpu::open().is_none() {
        return;
    }
    let folder = Folder::new();
    let (shown, quiet) = (folder.at("shown.png"), folder.at("quiet.png"));
    let scene = ["render", "tests/data/small.toml", "--size", "320x200", "--spp", "64", "--tile", "64"];
    let mut child = command().args(scene).args(["-o", &shown, "--preview=1"]).spawn().expect("the program");
    let mut partial = 0;
    while child.try_wait().unwrap().is_none() {
        if let Ok(meta) = io::read_metadata(&shown) {
            partial += u32::from(meta.get("complete") == Some("false"));
        }
        thread::sleep(Duration::from_millis(20));
    }
    assert!(child.wait().unwrap().success());
    assert!(partial > 0, "no unfinished picture was seen");
    assert_eq!(io::read_metadata(&shown).unwrap().get("complete"), None);
    pelage(&[&scene[..], &["-o", &quiet]].concat()).expect(0, &[]);
    assert_eq!(io::read(&shown).unwrap(), io::read(&quiet).unwrap());
    assert_eq!(folder.names(), ["quiet.png", "shown.png"]);
}
