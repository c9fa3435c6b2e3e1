//! Coordinates of points: `points.min` and `points.ts`, and texts.

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

/// The points in such a file that holds `count` of them, whatever their number of coordinates; `None` if its size fits no
/// number of coordinates, or if a number is not finite.
pub fn counted_points(bytes: &[u8], count: usize) -> Option<Vec<Vec<f64>>> {
    if count == 0 {
        return bytes.is_empty().then(Vec::new);
    }
    let whole = bytes.len().is_multiple_of(8 * count);
    whole
        .then(|| read_points(bytes, bytes.len() / (8 * count)))
        .flatten()
}

/// A text is no list of points.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PointsError {
    /// The bytes are no UTF-8.
    #[error("it is not text")]
    NoText,
    /// A word is no finite number.
    #[error("line {line}: `{word}` is not a finite number")]
    NoNumber {
        /// Number of the line, from 1.
        line: usize,
        /// The word.
        word: String,
    },
}

/// The points in a text with one point on each line. Numbers are separated by blanks or commas, `#` begins a comment, and lines
/// without numbers are left out. Points may differ in their counts of numbers.
///
/// # Errors
/// If the bytes are no text, or a word is no finite number.
pub fn points_of_text(bytes: &[u8]) -> Result<Vec<Vec<f64>>, PointsError> {
    let text = std::str::from_utf8(bytes).ok().ok_or(PointsError::NoText)?;
    let mut points = Vec::new();
    for (row, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        let words = line.split(|c: char| c.is_whitespace() || c == ',');
        let numbers = words.filter(|word| !word.is_empty()).map(|word| {
            let number = word.parse().ok().filter(|number: &f64| number.is_finite());
            number.ok_or_else(|| PointsError::NoNumber {
                line: row + 1,
                word: word.to_owned(),
            })
        });
        let point: Vec<f64> = numbers.collect::<Result<_, _>>()?;
        if !point.is_empty() {
            points.push(point);
        }
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_read() {
        assert_eq!(
            points_of_text(b"1, 2\n# no\n\n3\t4 # yes\n").unwrap(),
            [[1.0, 2.0], [3.0, 4.0]]
        );
        let error = points_of_text(b"1 2\n3 x\n").unwrap_err().to_string();
        assert_eq!(error, "line 2: `x` is not a finite number");
        assert!(points_of_text(b"1 inf").is_err());
        assert_eq!(points_of_text(&[0xff]), Err(PointsError::NoText));
    }

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
        assert_eq!(counted_points(&bytes, 2).unwrap(), written);
        assert_eq!(counted_points(&[], 0).unwrap().len(), 0);
    }

    #[test]
    fn damaged_files_are_refused() {
        let bytes = points([[1.0, 2.0].as_slice()]);
        assert!(read_points(&bytes, 3).is_none() && read_points(&bytes, 0).is_none());
        assert!(read_points(&bytes[..15], 2).is_none());
        assert!(counted_points(&bytes, 3).is_none() && counted_points(&bytes, 0).is_none());
        assert!(counted_points(&[], 1).is_none());
        assert!(read_points(&points([[f64::NAN].as_slice()]), 1).is_none());
    }
}
