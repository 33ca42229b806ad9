//! An array: its name, its shape, and what is in it.

use super::element::{Element, Elements, Order, kind};
use super::fault::MatFault;

/// Classes of an array.
mod class {
    pub const CELL: u32 = 1;
    pub const STRUCT: u32 = 2;
    pub const OBJECT: u32 = 3;
    pub const CHAR: u32 = 4;
    pub const SPARSE: u32 = 5;
    pub const DOUBLE: u32 = 6;
    pub const UINT64: u32 = 15;
    pub const FUNCTION: u32 = 16;
    pub const OPAQUE: u32 = 17;
}

/// Flag of an array with imaginary parts.
const COMPLEX: u32 = 0x0800;

/// Structures within structures beyond this are not looked into: Simulink's have two.
const DEEPEST: usize = 3;

/// An array, or what stands in its place.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Array {
    pub name: String,
    pub shape: Vec<usize>,
    pub content: Content,
}

/// What is in an array.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Content {
    /// Real numbers, column after column.
    Numbers(Vec<f64>),
    /// Text in one row.
    Text(String),
    /// Structures, one after the other: the values of their fields, by name.
    Structs(Vec<Vec<Array>>),
    /// Something that is no signal, in a word.
    Other(&'static str),
}

impl Array {
    /// The array in an element of type [`kind::MATRIX`].
    pub fn of(outer: &Elements<'_>, element: Element<'_>) -> Result<Array, MatFault> {
        Array::at_depth(outer, element, 0)
    }

    fn at_depth(outer: &Elements<'_>, element: Element<'_>, depth: usize) -> Result<Array, MatFault> {
        let mut parts = outer.within(element);
        if element.data.is_empty() {
            return Ok(Array { name: String::new(), shape: vec![0, 0], content: Content::Numbers(Vec::new()) });
        }
        let order = parts.order;
        let flags = parts.needed(kind::UINT32, "no flags of an array")?;
        let flags = *words(flags.data, order).first().ok_or_else(|| parts.malformed("no flags of an array"))?;
        let class = flags & 0xff;
        if class == class::OPAQUE {
            let name = parts.next()?.map(|name| String::from_utf8_lossy(name.data).into_owned());
            return Ok(Array { name: name.unwrap_or_default(), shape: Vec::new(), content: Content::Other("object") });
        }
        let shape = words(parts.needed(kind::INT32, "no shape of an array")?.data, order);
        let shape: Vec<usize> = shape.into_iter().map(|length| length as usize).collect();
        let name = String::from_utf8_lossy(parts.needed(kind::INT8, "no name of an array")?.data).into_owned();
        let content = match class {
            class::DOUBLE..=class::UINT64 if flags & COMPLEX != 0 => Content::Other("complex"),
            class::DOUBLE..=class::UINT64 => Content::Numbers(numbers(&mut parts, &shape)?),
            class::CHAR => text(&mut parts)?,
            class::STRUCT if depth < DEEPEST => Content::Structs(structs(&mut parts, &shape, depth)?),
            class::STRUCT => Content::Other("structure"),
            class::CELL => Content::Other("cells"),
            class::SPARSE => Content::Other("sparse"),
            class::OBJECT => Content::Other("object"),
            class::FUNCTION => Content::Other("function"),
            _ => return Err(parts.malformed("an array of an unknown class")),
        };
        Ok(Array { name, shape, content })
    }
}

fn words(data: &[u8], order: Order) -> Vec<u32> {
    data.as_chunks().0.iter().map(|word| order.u32(*word)).collect()
}

fn numbers(parts: &mut Elements<'_>, shape: &[usize]) -> Result<Vec<f64>, MatFault> {
    let before = *parts;
    let element = parts.next()?.ok_or_else(|| before.malformed("no numbers in an array"))?;
    let numbers = decoded(element, parts.order).ok_or_else(|| before.malformed("numbers of an unknown type"))?;
    let count = shape.iter().try_fold(1usize, |product, length| product.checked_mul(*length));
    if count != Some(numbers.len()) {
        return Err(before.malformed("an array whose numbers are not as many as its shape says"));
    }
    Ok(numbers)
}

/// Numbers of any type as doubles; nothing for what is no numbers, or half of one.
///
/// NUMERICS: whole numbers beyond 2^53 are rounded.
fn decoded(element: Element<'_>, order: Order) -> Option<Vec<f64>> {
    /// Each number, as it stands in the file's order.
    macro_rules! each {
        ($type:ty) => {{
            let (numbers, rest) = element.data.as_chunks::<{ size_of::<$type>() }>();
            let number = |bytes: &[u8; size_of::<$type>()]| match order {
                Order::Little => <$type>::from_le_bytes(*bytes) as f64,
                Order::Big => <$type>::from_be_bytes(*bytes) as f64,
            };
            rest.is_empty().then(|| numbers.iter().map(number).collect())
        }};
    }
    match element.kind {
        1 => each!(i8),
        2 => each!(u8),
        3 => each!(i16),
        4 => each!(u16),
        5 => each!(i32),
        6 => each!(u32),
        7 => each!(f32),
        9 => each!(f64),
        12 => each!(i64),
        13 => each!(u64),
        _ => None,
    }
}

fn text(parts: &mut Elements<'_>) -> Result<Content, MatFault> {
    const UTF8: u32 = 16;
    let Some(element) = parts.next()? else { return Ok(Content::Text(String::new())) };
    Ok(Content::Text(match decoded(element, parts.order) {
        Some(units) => {
            let units: Vec<u16> = units.into_iter().map(|unit| unit as u16).collect();
            String::from_utf16_lossy(&units)
        }
        None if element.kind == UTF8 => String::from_utf8_lossy(element.data).into_owned(),
        // UTF-16, which has a type of its own.
        None => String::from_utf16_lossy(
            &element.data.as_chunks().0.iter().map(|b| u16::from_le_bytes(*b)).collect::<Vec<_>>(),
        ),
    }))
}

fn structs(parts: &mut Elements<'_>, shape: &[usize], depth: usize) -> Result<Vec<Vec<Array>>, MatFault> {
    let before = *parts;
    let length = words(parts.needed(kind::INT32, "no length of field names")?.data, parts.order);
    let length = length.first().map_or(0, |length| *length as usize);
    let names = parts.needed(kind::INT8, "no field names")?.data;
    if length == 0 || !names.len().is_multiple_of(length) {
        return Err(before.malformed("field names of no length"));
    }
    let name =
        |bytes: &[u8]| String::from_utf8_lossy(bytes.split(|byte| *byte == 0).next().unwrap_or(&[])).into_owned();
    let names: Vec<String> = names.chunks(length).map(name).collect();
    let count = shape.iter().try_fold(1usize, |product, length| product.checked_mul(*length));
    let count = count.ok_or_else(|| before.malformed("more structures than there can be"))?;
    let mut found = Vec::new();
    // Each field is an element, so no more structures than bytes can be there, unless they have no fields.
    for _ in 0..if names.is_empty() { 0 } else { count } {
        let mut fields = Vec::new();
        for name in &names {
            let element = parts.needed(kind::MATRIX, "no value of a field")?;
            fields.push(Array { name: name.clone(), ..Array::at_depth(parts, element, depth + 1)? });
        }
        found.push(fields);
    }
    Ok(found)
}
