//! JSON writer that rejects NaN and infinity.
//!
//! serde_json writes NaN and infinity as `null`, which is indistinguishable from a missing value. Here they are an
//! error that names the key; `null` always means `None`.

use serde::Serialize;
use serde::ser;

/// A value that cannot be written as JSON.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum JsonError {
    /// A number is NaN or infinite.
    #[error("`{path}` is {value}, not a finite number")]
    NotFinite {
        /// Path of the number, e.g. `cases[3].claims[0].measured`.
        path: String,
        /// NaN, inf or -inf.
        value: f64,
    },
    /// The value has no JSON form, such as a map whose keys are not strings.
    #[error("no JSON form: {source}")]
    Shape {
        /// Error of serde_json.
        #[from]
        source: serde_json::Error,
    },
}

/// Writes indented JSON with a final newline.
///
/// # Errors
/// [`JsonError::NotFinite`] for a NaN or infinity anywhere in `value`; [`JsonError::Shape`] if it has no JSON form.
pub fn to_json<T: Serialize + ?Sized>(value: &T) -> Result<String, JsonError> {
    check(value)?;
    let mut text = serde_json::to_string_pretty(value)?;
    text.push('\n');
    Ok(text)
}

/// Writes indented JSON with a final newline, with `null` in the place of NaN and infinity; the first of them is returned too.
///
/// # Errors
/// [`JsonError::Shape`] if it has no JSON form.
pub fn to_json_with_null<T: Serialize + ?Sized>(
    value: &T,
) -> Result<(String, Option<JsonError>), JsonError> {
    let not_finite = match check(value) {
        Err(error @ JsonError::Shape { .. }) => return Err(error),
        checked => checked.err(),
    };
    let text = serde_json::to_string_pretty(value)? + "\n";
    Ok((text, not_finite))
}

/// Checks that every number in `value` is finite.
///
/// # Errors
/// [`JsonError::NotFinite`], naming the key.
pub fn check<T: Serialize + ?Sized>(value: &T) -> Result<(), JsonError> {
    value.serialize(Walk).map_err(|error| match error {
        WalkError::NotFinite { steps, value } => {
            let path: String = steps.iter().rev().map(String::as_str).collect();
            JsonError::NotFinite { path: path.trim_start_matches('.').to_owned(), value }
        }
        WalkError::Message(text) => JsonError::Shape { source: ser::Error::custom(text) },
    })
}

/// A serializer that writes nothing and checks floats.
struct Walk;

/// The elements of a list, or the values of a map, in sequence.
#[derive(Default)]
struct Elements {
    index: usize,
    key: String,
    /// The enum variant that holds them, a separate step in the path.
    variant: Option<&'static str>,
}

#[derive(Debug, thiserror::Error)]
enum WalkError {
    /// Steps of the path from the innermost outwards, as `.key` or `[i]`.
    #[error("{value}")]
    NotFinite { steps: Vec<String>, value: f64 },
    #[error("{0}")]
    Message(String),
}

impl WalkError {
    fn inside(mut self, step: String) -> Self {
        if let Self::NotFinite { steps, .. } = &mut self {
            steps.push(step);
        }
        self
    }
}

impl ser::Error for WalkError {
    fn custom<T: std::fmt::Display>(message: T) -> Self {
        Self::Message(message.to_string())
    }
}

type Walked = Result<(), WalkError>;

impl Elements {
    const fn of_variant(variant: &'static str) -> Self {
        Self { index: 0, key: String::new(), variant: Some(variant) }
    }

    fn walk<T: Serialize + ?Sized>(&mut self, step: String, value: &T) -> Walked {
        self.index += 1;
        value.serialize(Walk).map_err(|error| {
            let error = error.inside(step);
            match self.variant {
                Some(variant) => error.inside(format!(".{variant}")),
                None => error,
            }
        })
    }
}

macro_rules! nothing_to_check {
    ($($method:ident: $type:ty),* $(,)?) => { $(fn $method(self, _: $type) -> Walked { Ok(()) })* };
}

impl ser::Serializer for Walk {
    type Ok = ();
    type Error = WalkError;
    type SerializeSeq = Elements;
    type SerializeTuple = Elements;
    type SerializeTupleStruct = Elements;
    type SerializeTupleVariant = Elements;
    type SerializeMap = Elements;
    type SerializeStruct = Elements;
    type SerializeStructVariant = Elements;

    nothing_to_check! {
        serialize_bool: bool, serialize_char: char, serialize_str: &str, serialize_bytes: &[u8],
        serialize_i8: i8, serialize_i16: i16, serialize_i32: i32, serialize_i64: i64, serialize_i128: i128,
        serialize_u8: u8, serialize_u16: u16, serialize_u32: u32, serialize_u64: u64, serialize_u128: u128,
        serialize_unit_struct: &'static str,
    }

    fn serialize_f32(self, value: f32) -> Walked {
        self.serialize_f64(f64::from(value))
    }
    fn serialize_f64(self, value: f64) -> Walked {
        if value.is_finite() {
            Ok(())
        } else {
            Err(WalkError::NotFinite { steps: Vec::new(), value })
        }
    }
    fn serialize_none(self) -> Walked {
        Ok(())
    }
    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Walked {
        value.serialize(self)
    }
    fn serialize_unit(self) -> Walked {
        Ok(())
    }
    fn serialize_unit_variant(self, _: &'static str, _: u32, _: &'static str) -> Walked {
        Ok(())
    }
    fn serialize_newtype_struct<T: Serialize + ?Sized>(self, _: &'static str, value: &T) -> Walked {
        value.serialize(self)
    }
    fn serialize_newtype_variant<T: Serialize + ?Sized>(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        value: &T,
    ) -> Walked {
        value.serialize(self).map_err(|error| error.inside(format!(".{variant}")))
    }
    fn serialize_seq(self, _: Option<usize>) -> Result<Elements, WalkError> {
        Ok(Elements::default())
    }
    fn serialize_tuple(self, _: usize) -> Result<Elements, WalkError> {
        Ok(Elements::default())
    }
    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Elements, WalkError> {
        Ok(Elements::default())
    }
    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        _: usize,
    ) -> Result<Elements, WalkError> {
        Ok(Elements::of_variant(variant))
    }
    fn serialize_map(self, _: Option<usize>) -> Result<Elements, WalkError> {
        Ok(Elements::default())
    }
    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Elements, WalkError> {
        Ok(Elements::default())
    }
    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        _: usize,
    ) -> Result<Elements, WalkError> {
        Ok(Elements::of_variant(variant))
    }
}

macro_rules! walk_lists {
    ($($trait:ident :: $method:ident),* $(,)?) => { $(
        impl ser::$trait for Elements {
            type Ok = ();
            type Error = WalkError;
            fn $method<T: Serialize + ?Sized>(&mut self, value: &T) -> Walked {
                self.walk(format!("[{}]", self.index), value)
            }
            fn end(self) -> Walked {
                Ok(())
            }
        }
    )* };
}

macro_rules! walk_structs {
    ($($trait:ident),* $(,)?) => { $(
        impl ser::$trait for Elements {
            type Ok = ();
            type Error = WalkError;
            fn serialize_field<T: Serialize + ?Sized>(&mut self, key: &'static str, value: &T) -> Walked {
                self.walk(format!(".{key}"), value)
            }
            fn end(self) -> Walked {
                Ok(())
            }
        }
    )* };
}

walk_lists! {
    SerializeSeq::serialize_element,
    SerializeTuple::serialize_element,
    SerializeTupleStruct::serialize_field,
    SerializeTupleVariant::serialize_field,
}
walk_structs! { SerializeStruct, SerializeStructVariant }

impl ser::SerializeMap for Elements {
    type Ok = ();
    type Error = WalkError;
    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Walked {
        // A key that is not a string has no JSON form; the writer reports it afterwards.
        let text = serde_json::to_string(key).unwrap_or_default();
        self.key = text.trim_matches('"').into();
        Ok(())
    }
    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Walked {
        self.walk(format!(".{}", self.key), value)
    }
    fn end(self) -> Walked {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    #[derive(Serialize)]
    struct Sample {
        label: &'static str,
        series: Vec<(f64, Option<f64>)>,
        by_name: BTreeMap<String, Kind>,
    }

    #[derive(Serialize)]
    enum Kind {
        Plain,
        Value(f64),
        Range { from: f64, to: f64 },
    }

    fn sample() -> Sample {
        let by_name = BTreeMap::from([
            ("a".to_owned(), Kind::Plain),
            ("b".to_owned(), Kind::Value(1.0)),
            ("c".to_owned(), Kind::Range { from: 0.0, to: 1.0 }),
        ]);
        Sample { label: "sample", series: vec![(0.0, None), (1.0, Some(2.0))], by_name }
    }

    #[test]
    fn finite_numbers_and_none_are_written() {
        let text = to_json(&sample()).unwrap();
        assert!(
            text.contains("null")
                && text.contains("\"label\": \"sample\"")
                && text.ends_with("}\n")
        );
    }

    #[test]
    fn nan_and_infinity_become_null_where_it_is_asked() {
        let mut value = sample();
        assert!(to_json_with_null(&value).unwrap().1.is_none());
        value.series[1].1 = Some(f64::INFINITY);
        let (text, not_finite) = to_json_with_null(&value).unwrap();
        let path = "`series[1][1]` is inf, not a finite number";
        assert_eq!(not_finite.unwrap().to_string(), path);
        value.series[1].1 = None;
        assert_eq!(text, to_json(&value).unwrap());
    }

    #[test]
    fn nan_and_infinity_are_refused_with_their_key() {
        let mut value = sample();
        value.series[1].1 = Some(f64::NAN);
        assert_eq!(
            to_json(&value).unwrap_err().to_string(),
            "`series[1][1]` is NaN, not a finite number"
        );
        let mut value = sample();
        value.by_name.insert("c".to_owned(), Kind::Range { from: 0.0, to: f64::INFINITY });
        assert_eq!(
            to_json(&value).unwrap_err().to_string(),
            "`by_name.c.Range.to` is inf, not a finite number"
        );
        let mut value = sample();
        value.by_name.insert("b".to_owned(), Kind::Value(f64::NEG_INFINITY));
        assert!(to_json(&value).unwrap_err().to_string().contains("is -inf"));
    }
}
