//! Coordinates of stationary points: `points.min` and `points.ts`.

/// The bytes of `points.min` or `points.ts`: for each point, in the order of `min.data` or `ts.data`, its coordinates as
/// 64-bit floating-point numbers, least significant byte first, without anything between them. This is what PATHSAMPLE reads
/// and writes with direct access on usual computers.
pub fn points<'a>(points: impl IntoIterator<Item = &'a [f64]>) -> Vec<u8> {
    let numbers = points.into_iter().flatten();
    numbers.flat_map(|number| number.to_le_bytes()).collect()
}

/// The points in such a file, for a space of `coordinates` numbers; `None` if it does not consist of whole points or holds a
/// number that is not finite.
pub fn read_points(bytes: &[u8], coordinates: usize) -> Option<Vec<Vec<f64>>> {
    let record = 8 * coordinates;
    if record == 0 || !bytes.len().is_multiple_of(record) {
        return None;
    }
    let number = |bytes: &[u8]| {
        let number = <[u8; 8]>::try_from(bytes).map(f64::from_le_bytes).ok();
        number.filter(|number| number.is_finite())
    };
    let point = |point: &[u8]| point.chunks_exact(8).map(number).collect();
    bytes.chunks_exact(record).map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bit_survives() {
        let written = [
            vec![0.1 + 0.2, -1e-300, 3.0],
            vec![f64::MIN_POSITIVE, 0.0, 7.0],
        ];
        let bytes = points(written.iter().map(Vec::as_slice));
        assert_eq!(bytes.len(), 48);
        assert_eq!(read_points(&bytes, 3).unwrap(), written);
        assert_eq!(read_points(&bytes, 2).unwrap().len(), 3);
    }

    #[test]
    fn damaged_files_are_refused() {
        let bytes = points([[1.0, 2.0].as_slice()]);
        assert!(read_points(&bytes, 3).is_none() && read_points(&bytes, 0).is_none());
        assert!(read_points(&bytes[..15], 2).is_none());
        assert!(read_points(&points([[f64::NAN].as_slice()]), 1).is_none());
    }
}
