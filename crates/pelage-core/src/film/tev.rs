//! Sends pictures to the image viewer tev while they are rendered, by its protocol over TCP:
//! packets of a length (u32, itself included), an operation (u8) and its arguments, all
//! little-endian; text ends with a zero byte.

use super::Film;
use crate::{Error, Result};
use std::io::Write;
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

/// Where tev listens by default.
pub const ADDRESS: &str = "127.0.0.1:14158";

/// How long to wait for a viewer that does not answer or does not read.
const PATIENCE: Duration = Duration::from_secs(2);

/// Bytes of pixels in a packet, about.
const PACKET_BYTES: usize = 4 << 20;

/// Operation: makes an image of given size and channels.
const CREATE: u8 = 4;
/// Operation: replaces a rectangle of several channels, one after the other.
const UPDATE: u8 = 5;

const CHANNELS: [&str; 4] = ["R", "G", "B", "A"];

/// A connection to tev, and the picture that it shows.
#[derive(Debug)]
pub struct Tev {
    stream: TcpStream,
    address: String,
    name: String,
    size: Option<[u32; 2]>,
}

impl Tev {
    /// Connects to tev at `address` (HOST:PORT). `name`: the picture's name in its list.
    ///
    /// # Errors
    /// [`Error::Io`] if nobody answers there.
    pub fn connect(address: &str, name: &str) -> Result<Self> {
        let fail = |e: std::io::Error| {
            Error::io(address, format!("cannot be reached: {e}; start tev first, or name its HOST:PORT"))
        };
        let mut last = std::io::Error::other("the name has no address");
        for place in address.to_socket_addrs().map_err(fail)? {
            match TcpStream::connect_timeout(&place, PATIENCE) {
                Ok(stream) => {
                    stream.set_write_timeout(Some(PATIENCE)).map_err(fail)?;
                    // The protocol's text ends at a zero byte.
                    let name = name.replace('\0', " ");
                    return Ok(Self { stream, address: address.to_owned(), name, size: None });
                }
                Err(e) => last = e,
            }
        }
        Err(fail(last))
    }

    /// Shows `R G B A` of `film`, in place of what was sent before.
    ///
    /// # Errors
    /// [`Error::Io`] if the viewer has gone; [`Error::Unsupported`] for a film without them.
    pub fn show(&mut self, film: &Film) -> Result<()> {
        let pixels = film.premultiplied()?;
        let size = [film.width, film.height];
        if self.size != Some(size) {
            let mut packet = self.packet(CREATE);
            packet.extend(size.iter().flat_map(|n| n.to_le_bytes()));
            channels(&mut packet);
            self.send(packet)?;
            self.size = Some(size);
        }
        let width = film.width as usize;
        let rows = (PACKET_BYTES / (16 * width)).max(1);
        for (i, band) in pixels.chunks(rows * width).enumerate() {
            let mut packet = self.packet(UPDATE);
            channels(&mut packet);
            let [y, height] = [i * rows, band.len() / width].map(|n| n as u32);
            packet.extend([0, y, film.width, height].iter().flat_map(|n| n.to_le_bytes()));
            packet.extend((0..4).flat_map(|c| band.iter().flat_map(move |p| p[c].to_le_bytes())));
            self.send(packet)?;
        }
        Ok(())
    }

    /// The start of a packet: length, still unknown; operation; no grab of the focus; name.
    fn packet(&self, operation: u8) -> Vec<u8> {
        let mut packet = vec![0, 0, 0, 0, operation, 0];
        packet.extend(self.name.as_bytes());
        packet.push(0);
        packet
    }

    fn send(&mut self, mut packet: Vec<u8>) -> Result<()> {
        let length = packet.len() as u32; // Far below 4 GiB: widths are limited.
        packet[..4].copy_from_slice(&length.to_le_bytes());
        self.stream
            .write_all(&packet)
            .map_err(|e| Error::io(&self.address, format!("tev no longer takes pictures: {e}")))
    }
}

/// Number and names of the channels.
fn channels(packet: &mut Vec<u8>) {
    packet.extend((CHANNELS.len() as u32).to_le_bytes());
    packet.extend(CHANNELS.iter().flat_map(|name| [name.as_bytes(), &[0]].concat()));
}
