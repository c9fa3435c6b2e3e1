//! A pickle machine that only builds data: numbers, texts, lists, dictionaries, and arrays of numpy and torch.
//!
//! A pickle is a program for a stack machine that can call any function of Python. This machine never calls anything. It
//! knows the few names that numpy and torch write into their files, treats each as a keyword of the format, and refuses all
//! others. Copies of shared values are limited to a few times the length of the file, so that memory stays within some dozens
//! of times its length.

use std::collections::BTreeMap;

use super::array::{Numbers, Type};

/// Largest number of entries of a dictionary, because they are searched linearly.
const ENTRIES: usize = 1024;
/// Number of items and bytes that may be copied from shared values, per byte of the file.
const COPIES: usize = 4;

/// Index of a node in [`Heap`].
pub(crate) type Id = usize;

/// A value of a pickle. Values refer to each other by number, because they can be shared.
#[derive(Debug)]
pub(crate) enum Node {
    None,
    Bool(bool),
    Whole(i64),
    Number(f64),
    Text(String),
    Bytes(Vec<u8>),
    /// A list or a tuple.
    List(Vec<Id>),
    Dictionary(Vec<(Id, Id)>),
    /// A numpy type.
    Type(Type),
    /// A numpy array of numbers.
    Numbers(Numbers),
    /// The items of a numpy array of objects.
    Objects(Vec<Id>),
    /// Numbers beside the pickle: their type, and the text that is their key.
    Storage(Type, Id),
    /// One of the known functions, not yet applied.
    Word(Word),
    /// An array whose content has not been read yet.
    Blank,
}

/// The functions that numpy and torch write into their pickles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Word {
    Array,
    Reconstruct,
    Scalar,
    Dtype,
    FromBuffer,
    Encode,
    OrderedDict,
    Tensor,
    Parameter,
    Storage(Type),
}

const fn stored(kind: u8, size: usize) -> Word {
    Word::Storage(Type::Number {
        kind,
        size,
        big: false,
    })
}

const WORDS: [(&str, &str, Word); 22] = [
    ("numpy", "ndarray", Word::Array),
    ("numpy", "dtype", Word::Dtype),
    ("numpy.core.multiarray", "_reconstruct", Word::Reconstruct),
    ("numpy._core.multiarray", "_reconstruct", Word::Reconstruct),
    ("numpy.core.multiarray", "scalar", Word::Scalar),
    ("numpy._core.multiarray", "scalar", Word::Scalar),
    ("numpy.core.numeric", "_frombuffer", Word::FromBuffer),
    ("numpy._core.numeric", "_frombuffer", Word::FromBuffer),
    ("_codecs", "encode", Word::Encode),
    ("collections", "OrderedDict", Word::OrderedDict),
    ("numpy.dtypes", "Float64DType", Word::Dtype),
    ("numpy.dtypes", "Float32DType", Word::Dtype),
    ("torch._utils", "_rebuild_tensor_v2", Word::Tensor),
    ("torch._utils", "_rebuild_parameter", Word::Parameter),
    ("torch", "FloatStorage", stored(b'f', 4)),
    ("torch", "DoubleStorage", stored(b'f', 8)),
    ("torch", "LongStorage", stored(b'i', 8)),
    ("torch", "IntStorage", stored(b'i', 4)),
    ("torch", "ShortStorage", stored(b'i', 2)),
    ("torch", "CharStorage", stored(b'i', 1)),
    ("torch", "ByteStorage", stored(b'u', 1)),
    ("torch", "BoolStorage", stored(b'b', 1)),
];

/// All values of a pickle.
#[derive(Debug, Default)]
pub(crate) struct Heap {
    nodes: Vec<Node>,
}

impl Heap {
    pub(crate) fn node(&self, id: Id) -> &Node {
        &self.nodes[id]
    }

    /// The value of a text key in a dictionary.
    pub(crate) fn entry(&self, id: Id, key: &str) -> Option<Id> {
        let Node::Dictionary(entries) = self.node(id) else {
            return None;
        };
        let found = entries
            .iter()
            .rev()
            .find(|(name, _)| matches!(self.node(*name), Node::Text(text) if text == key));
        found.map(|(_, value)| *value)
    }

    /// The value as a single number.
    pub(crate) fn number(&self, id: Id) -> Option<f64> {
        match self.node(id) {
            Node::Number(value) => Some(*value),
            Node::Whole(value) => Some(*value as f64),
            Node::Bool(value) => Some(f64::from(u8::from(*value))),
            Node::Numbers(numbers) => match numbers.values[..] {
                [value] => Some(value),
                _ => None,
            },
            _ => None,
        }
    }

    /// The values of an array or list of at most `most` numbers, or a single number.
    pub(crate) fn few(&self, id: Id, most: usize) -> Option<Vec<f64>> {
        let length = match self.node(id) {
            Node::Numbers(numbers) => numbers.values.len(),
            Node::List(items) => items.len(),
            _ => 1,
        };
        let numbers = (length <= most).then(|| self.numbers(id)).flatten();
        numbers.map(|numbers| numbers.values)
    }

    /// The value as an array of numbers: an array, or a list of numbers.
    pub(crate) fn numbers(&self, id: Id) -> Option<Numbers> {
        match self.node(id) {
            Node::Numbers(numbers) => Some(numbers.clone()),
            Node::List(items) => {
                let values: Option<Vec<f64>> =
                    items.iter().map(|item| self.number(*item)).collect();
                Some(Numbers {
                    shape: vec![items.len()],
                    values: values?,
                })
            }
            _ => self.number(id).map(|value| Numbers {
                shape: Vec::new(),
                values: vec![value],
            }),
        }
    }

    /// The value as a list of texts.
    pub(crate) fn texts(&self, id: Id) -> Option<Vec<&str>> {
        let (Node::List(items) | Node::Objects(items)) = self.node(id) else {
            return None;
        };
        let texts = items.iter().map(|item| match self.node(*item) {
            Node::Text(text) => Some(text.as_str()),
            _ => None,
        });
        texts.collect()
    }

    fn add(&mut self, node: Node) -> Id {
        self.nodes.push(node);
        self.nodes.len() - 1
    }
}

/// Numbers that lie beside a pickle.
#[derive(Debug, Default)]
pub(crate) struct Storages<'a> {
    /// Their bytes, by key.
    pub(crate) numbers: BTreeMap<String, &'a [u8]>,
    /// Whether the highest byte of a number is its first.
    pub(crate) big: bool,
}

/// Runs a pickle. Returns its values and the number of the result. Errors are half a sentence that states the problem.
pub(crate) fn load(bytes: &[u8]) -> Result<(Heap, Id), String> {
    load_with(bytes, &Storages::default())
}

/// As [`load`], for a pickle with numbers beside it.
pub(crate) fn load_with(bytes: &[u8], storages: &Storages<'_>) -> Result<(Heap, Id), String> {
    let beside: usize = storages.numbers.values().map(|bytes| bytes.len()).sum();
    let mut machine = Machine {
        rest: bytes,
        storages,
        heap: Heap::default(),
        stack: Vec::new(),
        marks: Vec::new(),
        memo: Vec::new(),
        copies: (bytes.len() + beside)
            .saturating_mul(COPIES)
            .saturating_add(1024),
    };
    loop {
        let [code] = machine.take()?;
        if code == b'.' {
            let result = machine.pop()?;
            return Ok((machine.heap, result));
        }
        machine.step(code)?;
    }
}

struct Machine<'a> {
    rest: &'a [u8],
    storages: &'a Storages<'a>,
    heap: Heap,
    stack: Vec<Id>,
    /// Heights of the stack at the open marks.
    marks: Vec<usize>,
    memo: Vec<Option<Id>>,
    /// Number of items and bytes that may still be copied.
    copies: usize,
}

impl<'a> Machine<'a> {
    fn slice(&mut self, length: u64) -> Result<&'a [u8], String> {
        let length = usize::try_from(length).unwrap_or(usize::MAX);
        let cut = || "it is cut short".to_owned();
        let (head, rest) = self.rest.split_at_checked(length).ok_or_else(cut)?;
        self.rest = rest;
        Ok(head)
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let mut bytes = [0; N];
        bytes.copy_from_slice(self.slice(N as u64)?);
        Ok(bytes)
    }

    fn line(&mut self) -> Result<String, String> {
        let end = self.rest.iter().position(|&byte| byte == b'\n');
        let line = self.slice(end.map_or(u64::MAX, |end| end as u64))?;
        self.slice(1)?;
        Ok(String::from_utf8_lossy(line).into_owned())
    }

    fn length<const N: usize>(&mut self) -> Result<u64, String> {
        let mut bytes = [0; 8];
        bytes[..N].copy_from_slice(&self.take::<N>()?);
        Ok(u64::from_le_bytes(bytes))
    }

    fn push(&mut self, node: Node) {
        let id = self.heap.add(node);
        self.stack.push(id);
    }

    fn pop(&mut self) -> Result<Id, String> {
        // Values below a mark are not accessible.
        let floor = self.marks.last().copied().unwrap_or(0);
        if self.stack.len() <= floor {
            return Err("it takes a value from an empty stack".to_owned());
        }
        self.stack.pop().ok_or_else(String::new)
    }

    fn top(&self) -> Result<Id, String> {
        self.stack
            .last()
            .copied()
            .ok_or_else(|| "it needs a value, but the stack is empty".to_owned())
    }

    fn since_mark(&mut self) -> Result<Vec<Id>, String> {
        let mark = self
            .marks
            .pop()
            .ok_or("it closes a mark that is not open")?;
        Ok(self.stack.split_off(mark.min(self.stack.len())))
    }

    fn tuple(&mut self, count: usize) -> Result<(), String> {
        let mut items = (0..count)
            .map(|_| self.pop())
            .collect::<Result<Vec<_>, _>>()?;
        items.reverse();
        self.push(Node::List(items));
        Ok(())
    }

    fn text(&mut self, length: u64) -> Result<(), String> {
        let bytes = self.slice(length)?;
        self.push(Node::Text(String::from_utf8_lossy(bytes).into_owned()));
        Ok(())
    }

    fn bytes(&mut self, length: u64) -> Result<(), String> {
        let bytes = self.slice(length)?.to_vec();
        self.push(Node::Bytes(bytes));
        Ok(())
    }

    fn remember(&mut self, place: u64) -> Result<(), String> {
        let top = self.top()?;
        // Writers count up; a far index would only cost memory.
        let place = usize::try_from(place).unwrap_or(usize::MAX);
        if place > self.heap.nodes.len() + 1024 {
            return Err("the numbers of its values have gaps".to_owned());
        }
        if self.memo.len() <= place {
            self.memo.resize(place + 1, None);
        }
        self.memo[place] = Some(top);
        Ok(())
    }

    fn recall(&mut self, place: u64) -> Result<(), String> {
        let place = usize::try_from(place).unwrap_or(usize::MAX);
        let id = self.memo.get(place).copied().flatten();
        self.stack
            .push(id.ok_or("it refers to a value that does not exist")?);
        Ok(())
    }

    #[expect(clippy::too_many_lines, reason = "one line an opcode")]
    fn step(&mut self, code: u8) -> Result<(), String> {
        match code {
            // Protocol version and frames.
            0x80 => {
                self.take::<1>()?;
            }
            0x95 => {
                self.take::<8>()?;
            }
            b'(' => self.marks.push(self.stack.len()),
            b'0' => {
                self.pop()?;
            }
            b'1' => {
                self.since_mark()?;
            }
            b'2' => self.stack.push(self.top()?),
            b'N' => self.push(Node::None),
            0x88 => self.push(Node::Bool(true)),
            0x89 => self.push(Node::Bool(false)),
            b'J' => {
                let value = i32::from_le_bytes(self.take()?);
                self.push(Node::Whole(value.into()));
            }
            b'K' => {
                let [value] = self.take()?;
                self.push(Node::Whole(value.into()));
            }
            b'M' => {
                let value = u16::from_le_bytes(self.take()?);
                self.push(Node::Whole(value.into()));
            }
            0x8a => {
                let length = self.length::<1>()?;
                let bytes = self.slice(length)?;
                if bytes.len() > 8 {
                    return Err("it contains a whole number of more than 64 bits".to_owned());
                }
                let negative = bytes.last().is_some_and(|byte| byte & 0x80 != 0);
                let mut whole = [if negative { 0xff } else { 0 }; 8];
                whole[..bytes.len()].copy_from_slice(bytes);
                self.push(Node::Whole(i64::from_le_bytes(whole)));
            }
            b'G' => {
                let value = f64::from_be_bytes(self.take()?);
                self.push(Node::Number(value));
            }
            b'X' => self.length::<4>().and_then(|length| self.text(length))?,
            0x8c => self.length::<1>().and_then(|length| self.text(length))?,
            0x8d => self.length::<8>().and_then(|length| self.text(length))?,
            b'C' | b'U' => self.length::<1>().and_then(|length| self.bytes(length))?,
            b'B' | b'T' => self.length::<4>().and_then(|length| self.bytes(length))?,
            0x8e | 0x96 => self.length::<8>().and_then(|length| self.bytes(length))?,
            b']' | b')' => self.push(Node::List(Vec::new())),
            b'l' | b't' => {
                let items = self.since_mark()?;
                self.push(Node::List(items));
            }
            0x85 => self.tuple(1)?,
            0x86 => self.tuple(2)?,
            0x87 => self.tuple(3)?,
            b'}' => self.push(Node::Dictionary(Vec::new())),
            b'd' => {
                let entries = pairs(&self.since_mark()?);
                self.push(Node::Dictionary(Vec::new()));
                self.set(entries)?;
            }
            b'a' => {
                let item = self.pop()?;
                self.append(vec![item])?;
            }
            b'e' => {
                let items = self.since_mark()?;
                self.append(items)?;
            }
            b's' => {
                let value = self.pop()?;
                let key = self.pop()?;
                self.set(vec![(key, value)])?;
            }
            b'u' => {
                let entries = pairs(&self.since_mark()?);
                self.set(entries)?;
            }
            b'q' => self.length::<1>().and_then(|place| self.remember(place))?,
            b'r' => self.length::<4>().and_then(|place| self.remember(place))?,
            0x94 => self.remember(self.memo.len() as u64)?,
            b'h' => self.length::<1>().and_then(|place| self.recall(place))?,
            b'j' => self.length::<4>().and_then(|place| self.recall(place))?,
            b'c' => {
                let (module, name) = (self.line()?, self.line()?);
                self.word(&module, &name)?;
            }
            0x93 => {
                let (name, module) = (self.pop()?, self.pop()?);
                let [Node::Text(name), Node::Text(module)] =
                    [name, module].map(|id| self.heap.node(id))
                else {
                    return Err("the name of a function is not text".to_owned());
                };
                let (name, module) = (name.clone(), module.clone());
                self.word(&module, &name)?;
            }
            b'R' => self.apply()?,
            b'b' => self.build()?,
            b'Q' => self.storage()?,
            _ => {
                return Err(format!(
                    "it has the instruction {code:#04x}, which files of numpy and torch do not have: no code of a pickle is \
                     executed"
                ));
            }
        }
        Ok(())
    }

    /// Counts a copy of a value that may be shared.
    fn copy(&mut self, length: usize) -> Result<(), String> {
        let left = self.copies.checked_sub(length);
        self.copies = left.ok_or("it expands to far more values than its bytes can describe")?;
        Ok(())
    }

    /// Counts a copy of a list, a text or bytes.
    fn copy_of(&mut self, id: Id) -> Result<(), String> {
        self.copy(match self.heap.node(id) {
            Node::List(items) => items.len(),
            Node::Text(text) => text.len(),
            Node::Bytes(bytes) => bytes.len(),
            _ => 0,
        })
    }

    fn append(&mut self, items: Vec<Id>) -> Result<(), String> {
        let top = self.top()?;
        match &mut self.heap.nodes[top] {
            Node::List(list) => list.extend(items),
            _ => return Err("it appends to something other than a list".to_owned()),
        }
        Ok(())
    }

    fn set(&mut self, new: Vec<(Id, Id)>) -> Result<(), String> {
        let top = self.top()?;
        match &mut self.heap.nodes[top] {
            Node::Dictionary(entries) if entries.len() + new.len() > ENTRIES => {
                return Err(format!(
                    "it has a dictionary of more than {ENTRIES} entries"
                ));
            }
            Node::Dictionary(entries) => entries.extend(new),
            _ => return Err("it sets an entry of something other than a dictionary".to_owned()),
        }
        Ok(())
    }

    fn word(&mut self, module: &str, name: &str) -> Result<(), String> {
        let known = WORDS.iter().find(|(m, n, _)| *m == module && *n == name);
        let Some((_, _, word)) = known else {
            return Err(format!(
                "it calls {module}.{name}, which is not part of numpy's and torch's files: no code of a pickle is executed"
            ));
        };
        self.push(Node::Word(*word));
        Ok(())
    }

    fn items(&mut self, id: Id) -> Result<Vec<Id>, String> {
        self.copy_of(id)?;
        match self.heap.node(id) {
            Node::List(items) => Ok(items.clone()),
            _ => Err("it calls a function without a list of arguments".to_owned()),
        }
    }

    /// Numbers beside the pickle: `("storage", type, key, device, length)`.
    fn storage(&mut self) -> Result<(), String> {
        let told = self.pop()?;
        let wrong = "it refers to something other than a storage of torch";
        let parts = match self.heap.node(told) {
            Node::List(parts) => parts.as_slice(),
            _ => &[],
        };
        let &[_, kind, key, ..] = parts else {
            return Err(wrong.to_owned());
        };
        let Node::Word(Word::Storage(kind)) = *self.heap.node(kind) else {
            return Err(wrong.to_owned());
        };
        let kind = kind.ordered(if self.storages.big { ">" } else { "<" });
        self.push(Node::Storage(kind, key));
        Ok(())
    }

    /// A view of a storage: `(storage, offset, sides, strides, …)`, both in items.
    fn tensor(&mut self, arguments: &[Id]) -> Result<Numbers, String> {
        let wrong = || "it contains a tensor with unknown arguments".to_owned();
        let [storage, offset, shape, strides, ..] = *arguments else {
            return Err(wrong());
        };
        let (shape, strides) = (self.shape(shape)?, self.shape(strides)?);
        let &Node::Storage(kind, key) = self.heap.node(storage) else {
            return Err(wrong());
        };
        let Node::Text(key) = self.heap.node(key) else {
            return Err(wrong());
        };
        let storages = self.storages;
        let bytes = *(storages.numbers.get(key))
            .ok_or_else(|| format!("its storage `{key}` is missing"))?;
        let Node::Whole(offset) = *self.heap.node(offset) else {
            return Err(wrong());
        };
        let offset = usize::try_from(offset).ok().ok_or_else(wrong)?;
        if shape.len() != strides.len() {
            return Err(wrong());
        }
        let count = (shape.iter()).try_fold(1usize, |n, &side| n.checked_mul(side));
        let count = count.ok_or_else(|| format!("it has a tensor of shape {shape:?}"))?;
        self.copy(count)?;
        let place = |index: usize| {
            let mut rest = index;
            let mut place = offset;
            for (side, stride) in shape.iter().zip(&strides).rev() {
                place = place.saturating_add((rest % side).saturating_mul(*stride));
                rest /= side;
            }
            place
        };
        let values = kind.numbers_at(bytes, (0..count).map(place))?;
        Ok(Numbers { shape, values })
    }

    /// Calls one of the known functions.
    fn apply(&mut self) -> Result<(), String> {
        let arguments = self.pop()?;
        let function = self.pop()?;
        let arguments = self.items(arguments)?;
        let Node::Word(word) = *self.heap.node(function) else {
            return Err("it calls something other than a function".to_owned());
        };
        let shape = match (word, arguments.get(2)) {
            (Word::FromBuffer, Some(&shape)) => Some(self.shape(shape)?),
            _ => None,
        };
        if let (Word::FromBuffer | Word::Encode, Some(&content)) = (word, arguments.first()) {
            self.copy_of(content)?;
        }
        let wrong = || format!("it contains a {word:?} with unknown arguments").to_lowercase();
        if word == Word::Tensor {
            let tensor = self.tensor(&arguments)?;
            self.push(Node::Numbers(tensor));
            return Ok(());
        }
        if word == Word::Parameter {
            self.stack.push(*arguments.first().ok_or_else(wrong)?);
            return Ok(());
        }
        let argument = |place: usize| {
            arguments
                .get(place)
                .map(|id| self.heap.node(*id))
                .ok_or_else(wrong)
        };
        let made = match word {
            Word::Reconstruct | Word::Array => Node::Blank,
            Word::OrderedDict => Node::Dictionary(Vec::new()),
            Word::Dtype => match argument(0)? {
                Node::Text(code) => Node::Type(Type::parse(code)?),
                _ => return Err(wrong()),
            },
            Word::Scalar => match [argument(0)?, argument(1)?] {
                [Node::Type(kind), Node::Bytes(bytes)] => {
                    let values = kind.numbers(bytes, 1)?;
                    Node::Number(*values.first().ok_or_else(wrong)?)
                }
                _ => return Err(wrong()),
            },
            Word::FromBuffer => {
                let shape = shape.ok_or_else(wrong)?;
                let fortran = matches!(argument(3), Ok(Node::Text(order)) if order == "F");
                match [argument(0)?, argument(1)?] {
                    [Node::Bytes(bytes), Node::Type(kind)] => {
                        Node::Numbers(Numbers::decode(*kind, shape, fortran, bytes)?)
                    }
                    _ => return Err(wrong()),
                }
            }
            Word::Encode => match argument(0)? {
                Node::Text(text) => {
                    let byte = |c: char| u8::try_from(u32::from(c)).ok();
                    let bytes: Option<Vec<u8>> = text.chars().map(byte).collect();
                    Node::Bytes(bytes.ok_or_else(wrong)?)
                }
                _ => return Err(wrong()),
            },
            Word::Tensor | Word::Parameter | Word::Storage(_) => return Err(wrong()),
        };
        self.push(made);
        Ok(())
    }

    fn shape(&mut self, id: Id) -> Result<Vec<usize>, String> {
        let items = self.items(id)?;
        let side = |id: &Id| match self.heap.node(*id) {
            Node::Whole(side) => usize::try_from(*side).ok(),
            _ => None,
        };
        let shape: Option<Vec<usize>> = items.iter().map(side).collect();
        shape.ok_or_else(|| "it has an array whose shape is not a list of whole numbers".to_owned())
    }

    /// Fills an array, or sets the byte order of a type.
    fn build(&mut self) -> Result<(), String> {
        let state = self.pop()?;
        let target = self.top()?;
        let unknown = || "it fills something other than an array".to_owned();
        if !matches!(self.heap.node(state), Node::List(_)) {
            return Err(unknown());
        }
        let state = self.items(state)?;
        let shape = match (&self.heap.nodes[target], &state[..]) {
            (Node::Type(_), [_, order, ..]) => {
                self.copy_of(*order)?;
                None
            }
            (Node::Blank, [_, shape, _, _, data]) => {
                self.copy_of(*data)?;
                Some(self.shape(*shape)?)
            }
            _ => None,
        };
        let filled = match (&self.heap.nodes[target], &state[..]) {
            (Node::Type(kind), [_, order, ..]) => match self.heap.node(*order) {
                Node::Text(order) => Node::Type(kind.ordered(order)),
                Node::Bytes(order) => Node::Type(kind.ordered(&String::from_utf8_lossy(order))),
                _ => return Err(unknown()),
            },
            (Node::Blank, [_, _, kind, fortran, data]) => {
                let shape = shape.unwrap_or_default();
                let fortran = matches!(self.heap.node(*fortran), Node::Bool(true));
                match [self.heap.node(*kind), self.heap.node(*data)] {
                    [Node::Type(Type::Object), Node::List(items)] => {
                        let count = shape
                            .iter()
                            .try_fold(1usize, |n, &side| n.checked_mul(side));
                        if count != Some(items.len()) {
                            return Err(format!(
                                "it has an array of shape {shape:?} with {} items",
                                items.len()
                            ));
                        }
                        Node::Objects(items.clone())
                    }
                    [Node::Type(kind), Node::Bytes(bytes)] => {
                        Node::Numbers(Numbers::decode(*kind, shape, fortran, bytes)?)
                    }
                    _ => return Err("it has an array without type or content".to_owned()),
                }
            }
            _ => return Err(unknown()),
        };
        self.heap.nodes[target] = filled;
        Ok(())
    }
}

fn pairs(items: &[Id]) -> Vec<(Id, Id)> {
    items
        .chunks_exact(2)
        .map(|pair| (pair[0], pair[1]))
        .collect()
}
