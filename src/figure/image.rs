//! Raster images.

use super::FigureError;

/// Name of the program in picture files, by which it recognises its own files.
pub const MAKER: &str = "landscape";

/// A raster image, row by row from the top.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Red, green, blue of each pixel: 3 · width · height bytes.
    pub rgb: Vec<u8>,
}

impl Image {
    /// An image of one colour.
    pub fn filled(width: u32, height: u32, rgb: [u8; 3]) -> Self {
        Self {
            width,
            height,
            rgb: rgb.repeat(width as usize * height as usize),
        }
    }

    /// The image as a PNG file.
    ///
    /// # Errors
    /// [`FigureError::Draw`] if the image is empty or its bytes do not match its size.
    pub fn to_png(&self) -> Result<Vec<u8>, FigureError> {
        self.to_png_of(None)
    }

    /// As [`Image::to_png`], with a text in the file that says what the picture was made of.
    pub(super) fn to_png_of(&self, source: Option<&str>) -> Result<Vec<u8>, FigureError> {
        let refuse = |error: png::EncodingError| FigureError::Draw(error.to_string());
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::Best);
        encoder
            .add_text_chunk("Software".to_owned(), MAKER.to_owned())
            .map_err(refuse)?;
        if let Some(source) = source {
            let source = source.to_owned();
            encoder
                .add_text_chunk("Source".to_owned(), source)
                .map_err(refuse)?;
        }
        let mut writer = encoder.write_header().map_err(refuse)?;
        writer.write_image_data(&self.rgb).map_err(refuse)?;
        writer.finish().map_err(refuse)?;
        Ok(bytes)
    }

    /// Averages squares of `factor` × `factor` pixels.
    ///
    /// # Panics
    /// If a side is not a multiple of `factor`.
    #[must_use]
    pub fn reduced(&self, factor: u32) -> Self {
        assert!(
            self.width.is_multiple_of(factor) && self.height.is_multiple_of(factor),
            "sides must divide evenly"
        );
        let (width, height) = (self.width / factor, self.height / factor);
        let (step, row) = (factor as usize, self.width as usize * 3);
        let count = factor * factor;
        let mut rgb = Vec::with_capacity(width as usize * height as usize * 3);
        let mut sums = vec![0_u32; width as usize * 3];
        for rows in self.rgb.chunks_exact(step * row) {
            sums.fill(0);
            for row in rows.chunks_exact(row) {
                for (sum, block) in sums.chunks_exact_mut(3).zip(row.chunks_exact(3 * step)) {
                    for pixel in block.chunks_exact(3) {
                        for (sum, byte) in sum.iter_mut().zip(pixel) {
                            *sum += u32::from(*byte);
                        }
                    }
                }
            }
            let mean = |sum: &u32| {
                u8::try_from((sum + count / 2) / count).expect("a mean of bytes is a byte")
            };
            rgb.extend(sums.iter().map(mean));
        }
        Self { width, height, rgb }
    }

    /// Repeats every pixel `factor` times in both directions.
    pub(super) fn enlarged(&self, factor: u32) -> Self {
        let (width, height) = (self.width * factor, self.height * factor);
        let mut rgb = Vec::with_capacity(width as usize * height as usize * 3);
        for y in 0..height {
            for x in 0..width {
                let pixel =
                    ((y / factor) as usize * self.width as usize + (x / factor) as usize) * 3;
                rgb.extend_from_slice(&self.rgb[pixel..pixel + 3]);
            }
        }
        Self { width, height, rgb }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reducing_averages() {
        let image = Image {
            width: 2,
            height: 2,
            rgb: vec![0, 10, 255, 0, 20, 255, 4, 30, 255, 4, 40, 255],
        };
        assert_eq!(
            image.reduced(2),
            Image {
                width: 1,
                height: 1,
                rgb: vec![2, 25, 255]
            }
        );
        assert_eq!(image.enlarged(3).reduced(3), image);
    }
}
