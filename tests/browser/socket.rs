//! A websocket to a program on this machine, as far as browsers need it to be driven (RFC 6455).

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use serde_json::Value;

/// After this long without an answer a browser is given up.
const PATIENCE: Duration = Duration::from_mins(2);

/// An open websocket that carries JSON.
pub(super) struct Socket {
    stream: TcpStream,
}

impl Socket {
    /// Opens `ws://127.0.0.1:port/path`.
    pub(super) fn open(port: u16, path: &str) -> Self {
        let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        // The key proves nothing here, so any 16 bytes will do.
        let hello = format!(
            "GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
             Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
        );
        stream.write_all(hello.as_bytes()).unwrap();
        let mut answer = Vec::new();
        while !answer.ends_with(b"\r\n\r\n") {
            let mut byte = [0];
            stream.read_exact(&mut byte).unwrap();
            answer.push(byte[0]);
        }
        let answer = String::from_utf8_lossy(&answer).into_owned();
        assert!(answer.starts_with("HTTP/1.1 101"), "{answer}");
        Self { stream }
    }

    pub(super) fn send(&mut self, message: &Value) {
        self.frame(0x1, message.to_string().as_bytes());
    }

    /// One whole frame. Clients mask what they send; Firefox refuses a mask of zeros.
    fn frame(&mut self, kind: u8, content: &[u8]) {
        let mut frame = vec![0x80 | kind];
        match content.len() {
            short @ 0..=125 => frame.push(0x80 | u8::try_from(short).unwrap()),
            middle @ 126..=0xffff => {
                frame.push(0xfe);
                frame.extend(u16::try_from(middle).unwrap().to_be_bytes());
            }
            long => {
                frame.push(0xff);
                frame.extend((long as u64).to_be_bytes());
            }
        }
        let mask = [1, 2, 3, 4];
        frame.extend(mask);
        frame.extend(
            content
                .iter()
                .zip(mask.iter().cycle())
                .map(|(byte, mask)| byte ^ mask),
        );
        self.stream.write_all(&frame).unwrap();
    }

    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        let mut bytes = [0; N];
        self.stream
            .read_exact(&mut bytes)
            .expect("the browser answers");
        bytes
    }

    /// The next message.
    pub(super) fn receive(&mut self) -> Value {
        let mut message = Vec::new();
        loop {
            let [head, length] = self.bytes();
            let length = match length & 0x7f {
                126 => u64::from(u16::from_be_bytes(self.bytes())),
                127 => u64::from_be_bytes(self.bytes()),
                short => u64::from(short),
            };
            let mut content = vec![0; usize::try_from(length).unwrap()];
            self.stream.read_exact(&mut content).unwrap();
            match head & 0xf {
                0x8 => panic!("the browser ended the connection"),
                0x9 => self.frame(0xa, &content),
                0xa => {}
                _ => {
                    message.extend(content);
                    if head & 0x80 != 0 {
                        return serde_json::from_slice(&message).unwrap();
                    }
                }
            }
        }
    }
}
