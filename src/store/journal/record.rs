//! The bytes of a journal.
//!
//! ```text
//! head:    "landscape journal 1\n"  length u32  crc32 u32  fingerprint
//! record:  key length u32  payload length u32  crc32 u32  key  payload      (little-endian; the sum covers all else)
//! ```

const MAGIC: &[u8] = b"landscape journal 1\n";
const RECORD_HEAD: usize = 12;

pub(super) enum Head<'a> {
    Whole {
        fingerprint: &'a [u8],
        length: usize,
    },
    /// The head is empty or was cut off while it was written, so there are no records.
    Torn,
    /// Any other content, which may be valuable and is kept.
    Foreign,
}

pub(super) fn head(fingerprint: &str) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.extend(length_bytes(fingerprint.len()));
    bytes.extend(checksum(&[fingerprint.as_bytes()]).to_le_bytes());
    bytes.extend(fingerprint.as_bytes());
    bytes
}

pub(super) fn split_head<'a>(bytes: &'a [u8], expected: &str) -> Head<'a> {
    let whole = || {
        let rest = bytes.strip_prefix(MAGIC)?;
        let (numbers, rest) = rest.split_at_checked(8)?;
        let fingerprint = rest.get(..number(numbers) as usize)?;
        (checksum(&[fingerprint]) == number(&numbers[4..])).then_some(fingerprint)
    };
    match whole() {
        Some(fingerprint) => Head::Whole {
            fingerprint,
            length: MAGIC.len() + 8 + fingerprint.len(),
        },
        // A damaged length must not be taken for a torn head, because all records behind it would be lost.
        None if head(expected).starts_with(bytes) => Head::Torn,
        None => Head::Foreign,
    }
}

pub(super) fn record(key: &str, payload: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(RECORD_HEAD + key.len() + payload.len());
    bytes.extend(length_bytes(key.len()));
    bytes.extend(length_bytes(payload.len()));
    bytes.extend(checksum(&[&bytes, key.as_bytes(), payload]).to_le_bytes());
    bytes.extend(key.as_bytes());
    bytes.extend(payload);
    bytes
}

/// A complete record of a journal.
pub(super) struct Found<'a> {
    pub(super) key: &'a str,
    pub(super) payload: &'a [u8],
    /// Where the record ends.
    pub(super) end: usize,
}

/// All complete records from byte `start` on.
pub(super) fn records(bytes: &[u8], start: usize) -> impl Iterator<Item = Found<'_>> {
    let mut next = start;
    std::iter::from_fn(move || {
        let (key, payload) = first_record(&bytes[next..])?;
        next += RECORD_HEAD + key.len() + payload.len();
        Some(Found {
            key,
            payload,
            end: next,
        })
    })
}

fn first_record(bytes: &[u8]) -> Option<(&str, &[u8])> {
    let body = bytes.get(RECORD_HEAD..)?;
    let (key, rest) = body.split_at_checked(number(bytes) as usize)?;
    let payload = rest.get(..number(&bytes[4..]) as usize)?;
    (checksum(&[&bytes[..8], key, payload]) == number(&bytes[8..])).then_some(())?;
    Some((std::str::from_utf8(key).ok()?, payload))
}

fn length_bytes(length: usize) -> [u8; 4] {
    u32::try_from(length)
        .expect("a record is shorter than 4 GiB")
        .to_le_bytes()
}

/// The first four bytes as a number.
fn number(bytes: &[u8]) -> u32 {
    u32::from_le_bytes(bytes[..4].try_into().expect("four bytes make a number"))
}

fn checksum(parts: &[&[u8]]) -> u32 {
    let mut crc = flate2::Crc::new();
    for part in parts {
        crc.update(part);
    }
    crc.sum()
}
