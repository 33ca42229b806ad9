//! serde's view of a parsed TOML document that keeps the place of every value.
//!
//! Differs from the toml crate's own: NaN and infinities are refused where they stand, and unknown keys come with the
//! keys that are known.

use crate::extended::Extended;
use crate::fault::Fault;
use crate::misfit::Misfit;
use serde::de::value::StrDeserializer;
use serde::de::{self, DeserializeSeed, Deserializer, Error as _, IntoDeserializer, Unexpected, Visitor};
use serde::forward_to_deserialize_any;
use toml::Spanned;
use toml::de::{DeArray, DeInteger, DeTable, DeValue};

/// One value of the document.
#[derive(Clone, Copy)]
pub(crate) struct Node<'a> {
    value: &'a DeValue<'a>,
    /// Whether `inf` is a number here.
    extended: bool,
}

impl<'a> Node<'a> {
    pub(crate) fn of(value: &'a DeValue<'a>) -> Node<'a> {
        Node { value, extended: false }
    }

    fn unexpected(&self) -> Unexpected<'_> {
        match self.value {
            DeValue::String(text) => Unexpected::Str(text),
            DeValue::Boolean(x) => Unexpected::Bool(*x),
            DeValue::Array(_) => Unexpected::Seq,
            DeValue::Table(_) => Unexpected::Map,
            DeValue::Integer(x) => Unexpected::Other(x.as_str()),
            DeValue::Float(x) => Unexpected::Other(x.as_str()),
            DeValue::Datetime(_) => Unexpected::Other("a date"),
        }
    }

    fn float(&self, text: &str) -> Result<f64, Misfit> {
        let value: f64 = text.parse().map_err(Misfit::custom)?;
        let allowed = value.is_finite() || (self.extended && text.trim_start_matches(['+', '-']) == "inf");
        let fault = || Misfit::new(Fault::NotFinite { name: String::new(), text: text.into() });
        if allowed { Ok(value) } else { Err(fault()) }
    }
}

fn integer(x: &DeInteger<'_>) -> Result<i64, Misfit> {
    i64::from_str_radix(x.as_str(), x.radix())
        .map_err(|_| Misfit::invalid_value(Unexpected::Other(x.as_str()), &"a whole number of 64 bits"))
}

impl<'de> Deserializer<'de> for Node<'_> {
    type Error = Misfit;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misfit> {
        match self.value {
            DeValue::String(text) => visitor.visit_str(text),
            DeValue::Integer(x) => visitor.visit_i64(integer(x)?),
            DeValue::Float(x) => visitor.visit_f64(self.float(x.as_str())?),
            DeValue::Boolean(x) => visitor.visit_bool(*x),
            DeValue::Datetime(x) => visitor.visit_string(x.to_string()),
            DeValue::Array(entries) => all_entries(entries, visitor),
            DeValue::Table(table) => visitor.visit_map(Keys::of(table)),
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Misfit> {
        visitor.visit_some(self)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, name: &'static str, visitor: V) -> Result<V::Value, Misfit> {
        visitor.visit_newtype_struct(Node { extended: name == Extended::NAME, ..self })
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        match self.value {
            DeValue::Table(table) => visitor.visit_map(Keys::of(table)),
            _ => Err(Misfit::invalid_type(self.unexpected(), &visitor)),
        }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Misfit> {
        match self.value {
            DeValue::String(text) => visitor.visit_enum(StrDeserializer::new(text)),
            _ => Err(Misfit::invalid_type(self.unexpected(), &visitor)),
        }
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct seq tuple
        tuple_struct map identifier ignored_any
    }
}

/// Errors: a fault when the visitor leaves entries behind (a pair made of three).
fn all_entries<'de, V: Visitor<'de>>(entries: &DeArray<'_>, visitor: V) -> Result<V::Value, Misfit> {
    let mut visited = Entries { entries, next: 0 };
    let value = visitor.visit_seq(&mut visited)?;
    let (found, taken) = (entries.len(), visited.next);
    if taken == found { Ok(value) } else { Err(Misfit::invalid_length(found, &format!("{taken} entries").as_str())) }
}

struct Entries<'a> {
    entries: &'a DeArray<'a>,
    next: usize,
}

impl<'de> de::SeqAccess<'de> for &mut Entries<'_> {
    type Error = Misfit;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Misfit> {
        let Some(entry) = self.entries.get(self.next) else { return Ok(None) };
        let value = seed.deserialize(Node::of(entry.as_ref()));
        let value = value.map_err(|misfit| misfit.in_entry(self.next).at(entry.span().start))?;
        self.next += 1;
        Ok(Some(value))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.entries.len() - self.next)
    }
}

struct Keys<'a, I> {
    rest: I,
    /// The key just handed out, and its value.
    open: Option<(&'a str, &'a Spanned<DeValue<'a>>)>,
}

impl<'a> Keys<'a, ()> {
    fn of(table: &'a DeTable<'a>) -> Keys<'a, impl Iterator<Item = (&'a Spanned<Key<'a>>, &'a Spanned<DeValue<'a>>)>> {
        Keys { rest: table.iter(), open: None }
    }
}

type Key<'a> = std::borrow::Cow<'a, str>;

impl<'de, 'a, I> de::MapAccess<'de> for Keys<'a, I>
where
    I: Iterator<Item = (&'a Spanned<Key<'a>>, &'a Spanned<DeValue<'a>>)>,
{
    type Error = Misfit;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Misfit> {
        let Some((key, value)) = self.rest.next() else { return Ok(None) };
        let name: &str = key.as_ref();
        self.open = Some((name, value));
        let name: StrDeserializer<'_, Misfit> = name.into_deserializer();
        seed.deserialize(name).map(Some).map_err(|misfit| misfit.at(key.span().start))
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Misfit> {
        let (key, value) = self.open.take().expect("serde asks for a key before its value");
        let node = Node::of(value.as_ref());
        seed.deserialize(node).map_err(|misfit| misfit.under(key).at(value.span().start))
    }
}
