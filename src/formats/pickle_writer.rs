//! Writes arrays of dictionaries as numpy's pickles.

/// The beginning of an array: what numpy makes it with, and the version of its state.
const ARRAY: &[u8] =
    b"cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\nK\x00\x85C\x01b\x87R(K\x01";

/// Writes a one-dimensional numpy array of dictionaries in numpy's own form (protocol 3).
#[derive(Debug, Default)]
pub(crate) struct Writer {
    bytes: Vec<u8>,
}

impl Writer {
    /// Begins an array of `count` objects. Each object is then written, and [`Writer::finish`] ends the array.
    pub(crate) fn of_objects(count: usize) -> Self {
        let mut writer = Self::default();
        writer.raw(b"\x80\x03");
        writer.raw(ARRAY);
        writer.whole(count);
        writer.raw(b"\x85");
        writer.objects();
        writer
    }

    /// Begins an array without dimensions, which numpy writes for a single object. The object is then written, and
    /// [`Writer::finish`] ends the array.
    pub(crate) fn of_object() -> Self {
        let mut writer = Self::default();
        writer.raw(b"\x80\x03");
        writer.raw(ARRAY);
        writer.raw(b")");
        writer.objects();
        writer
    }

    /// The type of an array of objects, and the beginning of their list.
    fn objects(&mut self) {
        self.raw(b"cnumpy\ndtype\n");
        self.text("O8");
        self.raw(b"\x89\x88\x87R(K\x03");
        self.text("|");
        self.raw(b"NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\x3ftb\x89](");
    }

    pub(crate) fn finish(mut self) -> Vec<u8> {
        self.raw(b"etb.");
        self.bytes
    }

    pub(crate) fn open_dictionary(&mut self) {
        self.raw(b"}(");
    }

    pub(crate) fn close_dictionary(&mut self) {
        self.raw(b"u");
    }

    pub(crate) fn text(&mut self, text: &str) {
        self.raw(b"X");
        let length = u32::try_from(text.len()).unwrap_or(u32::MAX);
        self.raw(&length.to_le_bytes());
        self.raw(text.as_bytes());
    }

    pub(crate) fn number(&mut self, value: f64) {
        self.raw(b"G");
        self.raw(&value.to_be_bytes());
    }

    /// An array of numbers of one dimension.
    pub(crate) fn numbers(&mut self, values: &[f64]) {
        self.raw(ARRAY);
        self.whole(values.len());
        self.raw(b"\x85cnumpy\ndtype\n");
        self.text("f8");
        self.raw(b"\x89\x88\x87R(K\x03");
        self.text("<");
        self.raw(b"NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\x00tb\x89B");
        let length = u32::try_from(8 * values.len()).unwrap_or(u32::MAX);
        self.raw(&length.to_le_bytes());
        for value in values {
            self.raw(&value.to_le_bytes());
        }
        self.raw(b"tb");
    }

    /// A list of texts.
    pub(crate) fn texts<'a>(&mut self, texts: impl Iterator<Item = &'a str>) {
        self.raw(b"](");
        for text in texts {
            self.text(text);
        }
        self.raw(b"e");
    }

    fn whole(&mut self, value: usize) {
        self.raw(b"J");
        let value = i32::try_from(value).unwrap_or(i32::MAX);
        self.raw(&value.to_le_bytes());
    }

    fn raw(&mut self, bytes: &[u8]) {
        self.bytes.extend(bytes);
    }
}
