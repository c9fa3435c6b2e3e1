//! Writes arrays of dictionaries as numpy's pickles.

/// Writes a one-dimensional numpy array of dictionaries in numpy's own form (protocol 3).
#[derive(Debug, Default)]
pub(crate) struct Writer {
    bytes: Vec<u8>,
}

impl Writer {
    /// Begins an array of `count` objects. Each object is then written, and [`Writer::finish`] ends the array.
    pub(crate) fn of_objects(count: usize) -> Self {
        let mut writer = Self::default();
        writer.raw(b"\x80\x03cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\nK\x00\x85C\x01b\x87R(K\x01");
        writer.whole(count);
        writer.raw(b"\x85cnumpy\ndtype\n");
        writer.text("O8");
        writer.raw(b"\x89\x88\x87R(K\x03");
        writer.text("|");
        writer.raw(b"NNNJ\xff\xff\xff\xffJ\xff\xff\xff\xffK\x3ftb\x89](");
        writer
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

    fn whole(&mut self, value: usize) {
        self.raw(b"J");
        let value = i32::try_from(value).unwrap_or(i32::MAX);
        self.raw(&value.to_le_bytes());
    }

    fn raw(&mut self, bytes: &[u8]) {
        self.bytes.extend(bytes);
    }
}
