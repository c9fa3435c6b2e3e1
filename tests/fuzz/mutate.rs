//! Mutations of text and binary files, as in common fuzzers.

use landscape::sample::Rng;
use rand::RngExt;

/// Greatest length of an input, bytes.
const LONGEST: usize = 1 << 20;

/// Replacements of a number in a text.
const NUMBERS: &str = "0 1e-300 1e-30 1e30 1e155 -1 1 nan inf -inf 1e308 -1e308 1e-320 1e999 -0 4294967295 2147483648 18446744073709551616 0x10 ";

/// Replacements of a word in a binary file.
const WORDS: [u64; 10] = [
    0,
    1,
    0x7f,
    0xff,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    0x7fff_ffff_ffff_ffff,
    0x8000_0000_0000_0000,
    0xffff_ffff_ffff_ffff,
];

/// Applies one to six mutations to `seed`; pieces may come from `other`.
pub(crate) fn mutated(seed: &[u8], other: &[u8], rng: &mut Rng) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..rng.random_range(1..=6) {
        mutate(&mut bytes, other, rng);
        bytes.truncate(LONGEST);
    }
    bytes
}

/// A random piece of some bytes, usually short.
fn piece(bytes: &[u8], rng: &mut Rng) -> std::ops::Range<usize> {
    if bytes.is_empty() {
        return 0..0;
    }
    let longest = match rng.random_range(0..4) {
        0 => 4,
        1 => 32,
        2 => 512,
        _ => bytes.len(),
    };
    let first = rng.random_range(0..bytes.len());
    let length = rng.random_range(1..=longest);
    first..(first + length).min(bytes.len())
}

fn mutate(bytes: &mut Vec<u8>, other: &[u8], rng: &mut Rng) {
    let range = piece(bytes, rng);
    let at = range.start;
    match rng.random_range(0..11) {
        0 if !range.is_empty() => bytes[at] ^= 1u8 << rng.random_range(0..8),
        1 if !range.is_empty() => bytes[at] = rng.random_range(0..=255),
        2 => {
            bytes.drain(range);
        }
        3 => {
            let copy = bytes[range].to_vec();
            bytes.splice(at..at, copy);
        }
        // Deep nesting and long lists.
        4 => {
            let most = LONGEST / (range.len() + 1);
            let times = rng.random_range(0..=most.min(20_000));
            let copies = bytes[range.clone()].repeat(times);
            bytes.splice(at..at, copies);
        }
        5 => {
            let theirs = other[piece(other, rng)].to_vec();
            bytes.splice(range, theirs);
        }
        6 => bytes.truncate(at),
        7 | 8 => number(bytes, at, rng),
        9 => element(bytes, at, rng),
        _ => word(bytes, at, rng),
    }
}

/// Replaces the next number of a text.
fn number(bytes: &mut Vec<u8>, from: usize, rng: &mut Rng) {
    let digit = |byte: &u8| byte.is_ascii_digit();
    let Some(first) = bytes[from..].iter().position(digit) else {
        return;
    };
    let first = from + first;
    let length = (bytes[first..].iter())
        .take_while(|byte| byte.is_ascii_digit() || b".eE-+".contains(byte))
        .count();
    let numbers: Vec<&str> = NUMBERS.split(' ').collect();
    let new = numbers[rng.random_range(0..numbers.len())];
    bytes.splice(first..first + length, new.bytes());
}

/// Nests the next element, tag or list inside itself, perhaps many times.
fn element(bytes: &mut Vec<u8>, from: usize, rng: &mut Rng) {
    let opening = |byte: &u8| b"<[{(".contains(byte);
    let Some(first) = bytes[from..].iter().position(opening) else {
        return;
    };
    let first = from + first;
    let closing = |byte: &u8| b">]}):,".contains(byte);
    let Some(length) = bytes[first..].iter().position(closing) else {
        return;
    };
    let copy = bytes[first..=first + length].to_vec();
    let times = [1, 2, 100, 10_000, 100_000][rng.random_range(0..5)].min(LONGEST / copy.len());
    bytes.splice(first..first, copy.repeat(times));
}

/// Writes an extreme value of random length in either byte order.
fn word(bytes: &mut [u8], at: usize, rng: &mut Rng) {
    let value = WORDS[rng.random_range(0..WORDS.len())];
    let length = [1, 2, 4, 8][rng.random_range(0..4)];
    let mut word = value.to_le_bytes()[..length].to_vec();
    if rng.random_range(0..4) == 0 {
        word.reverse();
    }
    let end = (at + length).min(bytes.len());
    bytes[at..end].copy_from_slice(&word[..end - at]);
}
