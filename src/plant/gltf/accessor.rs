//! Accessors, read only after every length is checked.

use super::buffers::Buffers;
use super::error::Fault;
use crate::math::{Vec2, Vec3};
use gltf_json::accessor::{ComponentType, GenericComponentType, IndexComponentType, Type};
use gltf_json::validation::Checked;
use gltf_json::{Accessor, Root};
use std::cell::OnceCell;

/// The accessors of a document, each checked when first asked for.
#[derive(Debug)]
pub(super) struct Reader<'a> {
    root: &'a Root,
    buffers: Buffers<'a>,
    accessors: Vec<OnceCell<Result<Shape, Fault>>>,
}

impl<'a> Reader<'a> {
    pub(super) fn new(root: &'a Root, buffers: Buffers<'a>) -> Self {
        Self {
            root,
            buffers,
            accessors: root.accessors.iter().map(|_| OnceCell::new()).collect(),
        }
    }

    pub(super) fn buffers(&self) -> &Buffers<'a> {
        &self.buffers
    }

    /// The elements of an accessor that `pointer` names, if their type is `wanted`.
    pub(super) fn elements(
        &self,
        index: usize,
        pointer: &str,
        wanted: &Wanted,
    ) -> Result<Elements<'_>, Fault> {
        let Some(cell) = self.accessors.get(index) else {
            return Err(Fault::index(
                pointer,
                "accessor",
                index,
                self.accessors.len(),
            ));
        };
        let shape = cell.get_or_init(|| self.check(index));
        let shape = shape.as_ref().map_err(Fault::clone)?;
        let fail = |field: &str, found: String, want: String| {
            let message = format!("is {found}, but {pointer} wants {want}");
            Err(Fault::new(format!("/accessors/{index}/{field}"), message))
        };
        if shape.kind != wanted.kind {
            return fail(
                "type",
                format!("{:?}", shape.kind),
                format!("{:?}", wanted.kind),
            );
        }
        if !wanted.components.contains(&shape.component) {
            return fail(
                "componentType",
                format!("{} ({:?})", shape.component.as_gl_enum(), shape.component),
                format!("one of {:?}", wanted.components),
            );
        }
        let bytes = match shape.dense {
            Some((view, offset, _)) => &self.buffers.view(view, pointer)?.0[offset..],
            None => &[],
        };
        let sparse = match &shape.sparse {
            Some(sparse) => {
                let (view, offset) = sparse.indices;
                let indices = &self.buffers.view(view, pointer)?.0[offset..];
                let (view, offset) = sparse.values;
                let values = &self.buffers.view(view, pointer)?.0[offset..];
                Some((sparse, indices, values))
            }
            None => None,
        };
        Ok(Elements {
            shape,
            bytes,
            sparse,
        })
    }

    /// Checks once what every later read relies on.
    fn check(&self, index: usize) -> Result<Shape, Fault> {
        let accessor = &self.root.accessors[index];
        let at = |field: &str| format!("/accessors/{index}/{field}");
        let (kind, component) = kind_and_component(accessor, index)?;
        let element = component.size() * kind.multiplicity();
        let count = accessor.count.0;
        let offset = accessor.byte_offset.unwrap_or_default().0;
        let dense = match accessor.buffer_view {
            None => None,
            Some(view) => {
                let view = view.value();
                let (bytes, stride) = self.buffers.view(view, &at("bufferView"))?;
                let stride = stride.unwrap_or(element);
                if stride < element {
                    let message = format!(
                        "elements of {element} bytes do not fit the stride of buffer view {view}, {stride}"
                    );
                    return Err(Fault::new(at("type"), message));
                }
                let end = end_of(offset, count, stride, element);
                if end.is_none_or(|end| end > bytes.len() as u64) {
                    let message = format!(
                        "{count} elements of {element} bytes, {stride} apart, from byte {offset} pass \
                         the end of buffer view {view}, which has {}",
                        bytes.len()
                    );
                    return Err(Fault::new(at("count"), message));
                }
                let offset = usize::try_from(offset).unwrap_or(0).min(bytes.len());
                Some((view, offset, stride))
            }
        };
        let Ok(count) = usize::try_from(count) else {
            return Err(Fault::new(
                at("count"),
                format!("{count} exceeds this machine's sizes"),
            ));
        };
        let sparse = self.check_sparse(accessor, index, count, element)?;
        Ok(Shape {
            kind,
            component,
            normalized: accessor.normalized,
            count,
            element,
            dense,
            sparse,
        })
    }

    fn check_sparse(
        &self,
        accessor: &Accessor,
        index: usize,
        count: usize,
        element: usize,
    ) -> Result<Option<Sparse>, Fault> {
        let Some(sparse) = &accessor.sparse else {
            return Ok(None);
        };
        let at = |field: &str| format!("/accessors/{index}/sparse/{field}");
        let Some(length) = usize::try_from(sparse.count.0).ok().filter(|&n| n <= count) else {
            let message = format!(
                "replaces {} elements of an accessor that has {count}",
                sparse.count.0
            );
            return Err(Fault::new(at("count"), message));
        };
        let Checked::Valid(IndexComponentType(component)) = sparse.indices.component_type else {
            let message = "wanted 5121, 5123 or 5125 (unsigned integers)";
            return Err(Fault::new(at("indices/componentType"), message));
        };
        let part = |field: &str, view: usize, offset: u64, size: usize| {
            let (bytes, _) = self
                .buffers
                .view(view, &at(&format!("{field}/bufferView")))?;
            let end = end_of(offset, length as u64, size, size);
            if end.is_none_or(|end| end > bytes.len() as u64) {
                let message = format!(
                    "{length} elements of {size} bytes from byte {offset} pass the end of buffer view \
                     {view}, which has {}",
                    bytes.len()
                );
                return Err(Fault::new(at(field), message));
            }
            let offset = usize::try_from(offset).unwrap_or(0).min(bytes.len());
            Ok((view, offset))
        };
        let indices = &sparse.indices;
        let indices = part(
            "indices",
            indices.buffer_view.value(),
            indices.byte_offset.0,
            component.size(),
        )?;
        let values = &sparse.values;
        let values = part(
            "values",
            values.buffer_view.value(),
            values.byte_offset.0,
            element,
        )?;
        let bytes = &self.buffers.view(indices.0, &at("indices"))?.0[indices.1..];
        let mut least = 0_usize;
        for place in 0..length {
            let found = unsigned(&bytes[place * component.size()..], component) as usize;
            if found < least || found >= count {
                let message = format!(
                    "entry {place} is {found}, wanted at least {least} and below {count}, rising"
                );
                return Err(Fault::new(at("indices"), message));
            }
            least = found + 1;
        }
        Ok(Some(Sparse {
            count: length,
            component,
            indices,
            values,
        }))
    }
}

/// The type of element that a use of an accessor can read.
#[derive(Debug)]
pub(super) struct Wanted {
    pub(super) kind: Type,
    pub(super) components: &'static [ComponentType],
}

/// What a checked accessor looks like; views and offsets are known to be in range.
#[derive(Debug)]
struct Shape {
    kind: Type,
    component: ComponentType,
    normalized: bool,
    count: usize,
    /// The bytes of one element.
    element: usize,
    /// Buffer view, offset in it, stride; without it all elements are 0.
    dense: Option<(usize, usize, usize)>,
    sparse: Option<Sparse>,
}

/// Replaced elements: buffer view and offset of their indices and values.
#[derive(Debug)]
struct Sparse {
    count: usize,
    component: ComponentType,
    indices: (usize, usize),
    values: (usize, usize),
}

/// The elements of one accessor. Nothing is copied: what is not asked for costs nothing, however
/// many elements a document claims.
#[derive(Debug, Clone, Copy)]
pub(super) struct Elements<'r> {
    shape: &'r Shape,
    bytes: &'r [u8],
    sparse: Option<(&'r Sparse, &'r [u8], &'r [u8])>,
}

impl Elements<'_> {
    pub(super) fn count(&self) -> usize {
        self.shape.count
    }

    /// An element of two floats; `index` is below [`count`](Self::count).
    pub(super) fn vec2(&self, index: usize) -> Vec2 {
        Vec2::new(self.float(index, 0), self.float(index, 1))
    }

    /// An element of three floats.
    pub(super) fn vec3(&self, index: usize) -> Vec3 {
        let [x, y, z] = [0, 1, 2].map(|lane| self.float(index, lane));
        Vec3::new(x, y, z)
    }

    /// An unsigned element.
    pub(super) fn index(&self, index: usize) -> u32 {
        self.bytes_of(index)
            .map_or(0, |bytes| unsigned(bytes, self.shape.component))
    }

    fn float(&self, index: usize, lane: usize) -> f32 {
        let component = self.shape.component;
        let Some(bytes) = self.bytes_of(index) else {
            return 0.0;
        };
        let bytes = &bytes[lane * component.size()..];
        let (value, most) = match component {
            ComponentType::F32 => {
                let bytes = bytes[..4].try_into().expect("the slice has four bytes");
                return f32::from_le_bytes(bytes);
            }
            ComponentType::I8 => (f32::from(i8::from_le_bytes([bytes[0]])), 127.0),
            ComponentType::U8 => (f32::from(bytes[0]), 255.0),
            ComponentType::I16 => (f32::from(i16::from_le_bytes([bytes[0], bytes[1]])), 32767.0),
            ComponentType::U16 => (f32::from(u16::from_le_bytes([bytes[0], bytes[1]])), 65535.0),
            // `Wanted` lists no 32-bit integers for floats; their value serves as well.
            ComponentType::U32 => (unsigned(bytes, component) as f32, u32::MAX as f32),
        };
        if self.shape.normalized {
            (value / most).max(-1.0)
        } else {
            value
        }
    }

    /// The bytes of an element; `None` where it is 0 for want of a buffer view.
    fn bytes_of(&self, index: usize) -> Option<&[u8]> {
        let element = self.shape.element;
        if let Some((sparse, indices, values)) = self.sparse {
            let size = sparse.component.size();
            let (mut low, mut high) = (0, sparse.count);
            while low < high {
                let middle = low.midpoint(high);
                let found = unsigned(&indices[middle * size..], sparse.component) as usize;
                match found.cmp(&index) {
                    std::cmp::Ordering::Less => low = middle + 1,
                    std::cmp::Ordering::Greater => high = middle,
                    std::cmp::Ordering::Equal => {
                        return Some(&values[middle * element..(middle + 1) * element]);
                    }
                }
            }
        }
        let (_, _, stride) = self.shape.dense?;
        Some(&self.bytes[index * stride..index * stride + element])
    }
}

fn kind_and_component(accessor: &Accessor, index: usize) -> Result<(Type, ComponentType), Fault> {
    let at = |field: &str| format!("/accessors/{index}/{field}");
    let Checked::Valid(kind) = accessor.type_ else {
        let message = "wanted SCALAR, VEC2, VEC3, VEC4, MAT2, MAT3 or MAT4";
        return Err(Fault::new(at("type"), message));
    };
    let Checked::Valid(GenericComponentType(component)) = accessor.component_type else {
        let message = "wanted one of 5120, 5121, 5122, 5123, 5125, 5126";
        return Err(Fault::new(at("componentType"), message));
    };
    Ok((kind, component))
}

/// The little-endian unsigned integer at the start of `bytes`.
fn unsigned(bytes: &[u8], component: ComponentType) -> u32 {
    match component.size() {
        1 => u32::from(bytes[0]),
        2 => u32::from(u16::from_le_bytes([bytes[0], bytes[1]])),
        _ => super::container::le_u32(&bytes[..4]),
    }
}

/// Where the last of `count` elements ends; `None` past 2⁶⁴.
fn end_of(offset: u64, count: u64, stride: usize, element: usize) -> Option<u64> {
    match count.checked_sub(1) {
        None => Some(offset),
        Some(steps) => steps
            .checked_mul(stride as u64)?
            .checked_add(offset)?
            .checked_add(element as u64),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn root(json: &str) -> Root {
        let json = format!(r#"{{"asset":{{"version":"2.0"}},{json}}}"#);
        Root::from_str(&json).unwrap()
    }

    const FLOATS: Wanted = Wanted {
        kind: Type::Vec2,
        components: &[ComponentType::F32, ComponentType::U8],
    };

    /// 24 bytes: the floats 0, 1, …, 5.
    fn data() -> Vec<u8> {
        [0.0_f32, 1.0, 2.0, 3.0, 4.0, 5.0]
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect()
    }

    fn read(accessor: &str, views: &str) -> Result<Vec<[f32; 2]>, String> {
        let json = format!(
            r#""buffers":[{{"byteLength":24}}],"bufferViews":[{views}],"accessors":[{{{accessor}}}]"#
        );
        let root = root(&json);
        let data = data();
        let reader = Reader::new(&root, Buffers::new(&root, None, Some(&data)));
        let text = |fault: Fault| format!("{} {}", fault.pointer, fault.message);
        let elements = reader.elements(0, "/here", &FLOATS).map_err(text)?;
        Ok((0..elements.count())
            .map(|index| elements.vec2(index).to_array())
            .collect())
    }

    #[test]
    fn strides_offsets_and_normalized_bytes() {
        let packed = r#"{"buffer":0,"byteLength":24}"#;
        let all = r#""bufferView":0,"count":3,"componentType":5126,"type":"VEC2""#;
        let found = read(all, packed);
        assert_eq!(found, Ok(vec![[0.0, 1.0], [2.0, 3.0], [4.0, 5.0]]));
        let apart = r#"{"buffer":0,"byteOffset":4,"byteLength":20,"byteStride":12}"#;
        let two = r#""bufferView":0,"count":2,"componentType":5126,"type":"VEC2""#;
        assert_eq!(read(two, apart), Ok(vec![[1.0, 2.0], [4.0, 5.0]]));
        let bytes = r#""bufferView":0,"byteOffset":6,"count":1,"componentType":5121,"type":"VEC2",
            "normalized":true"#;
        let found = read(bytes, packed);
        assert_eq!(found, Ok(vec![[128.0 / 255.0, 63.0 / 255.0]]));
    }

    #[test]
    fn sparse_elements_over_views_and_over_nothing() {
        let views = r#"{"buffer":0,"byteLength":24},{"buffer":0,"byteOffset":4,"byteLength":2},
            {"buffer":0,"byteOffset":16,"byteLength":8}"#;
        // The bytes 0, 0, 128, 63 of the float 1: an index of u16 at byte 4 is 0.
        let sparse = r#""sparse":{"count":1,"indices":{"bufferView":1,"componentType":5123},
            "values":{"bufferView":2}}"#;
        let typed = r#""componentType":5126,"type":"VEC2""#;
        let over = format!(r#""bufferView":0,"count":2,{typed},{sparse}"#);
        assert_eq!(read(&over, views), Ok(vec![[4.0, 5.0], [2.0, 3.0]]));
        let bare = format!(r#""count":2,{typed},{sparse}"#);
        assert_eq!(read(&bare, views), Ok(vec![[4.0, 5.0], [0.0, 0.0]]));
        let none = format!(r#""count":2,{typed}"#);
        assert_eq!(read(&none, views), Ok(vec![[0.0; 2]; 2]));
    }

    #[test]
    fn hostile_numbers_are_refused_with_their_place() {
        let packed = r#"{"buffer":0,"byteLength":24}"#;
        let typed = r#""componentType":5126,"type":"VEC2""#;
        for (accessor, views, wanted) in [
            (
                r#""bufferView":0,"count":4294967295"#,
                packed,
                "/accessors/0/count 4294967295 ",
            ),
            (
                r#""bufferView":0,"count":4"#,
                packed,
                "/accessors/0/count 4 elements of 8",
            ),
            (
                r#""bufferView":0,"byteOffset":18446744073709551615,"count":2"#,
                packed,
                "/accessors/0/count 2 ",
            ),
            (
                r#""bufferView":9,"count":1"#,
                packed,
                "/accessors/0/bufferView names",
            ),
            (
                r#""bufferView":0,"count":1"#,
                r#"{"buffer":0,"byteLength":25}"#,
                "/bufferViews/0/byteLength 25 bytes",
            ),
            (
                r#""bufferView":0,"count":1"#,
                r#"{"buffer":0,"byteOffset":18446744073709551615,"byteLength":2}"#,
                "/bufferViews/0/byteLength 2 bytes",
            ),
            (
                r#""bufferView":0,"count":2"#,
                r#"{"buffer":0,"byteLength":24,"byteStride":4}"#,
                "/accessors/0/type elements of 8 bytes",
            ),
            (
                r#""bufferView":0,"count":1"#,
                r#"{"buffer":3,"byteLength":24}"#,
                "/bufferViews/0/buffer names buffer 3",
            ),
        ] {
            let message = read(&format!("{accessor},{typed}"), views).unwrap_err();
            assert!(message.starts_with(wanted), "{message}");
        }
        let wrong = r#""bufferView":0,"count":1,"componentType":5125,"type":"VEC2""#;
        let message = read(wrong, packed).unwrap_err();
        assert!(
            message.starts_with("/accessors/0/componentType is 5125"),
            "{message}"
        );
        let wrong = r#""bufferView":0,"count":1,"componentType":5126,"type":"VEC3""#;
        let message = read(wrong, packed).unwrap_err();
        assert!(
            message.starts_with("/accessors/0/type is Vec3"),
            "{message}"
        );
    }

    #[test]
    fn sparse_indices_must_rise_and_fit() {
        let views = r#"{"buffer":0,"byteLength":24},{"buffer":0,"byteOffset":6,"byteLength":2}"#;
        // The index bytes are 128 and 63: too large, and falling.
        for (count, wanted) in [
            (100, "entry 0 is 128"),
            (200, "entry 1 is 63"),
            (1, "replaces 2"),
        ] {
            let accessor = format!(
                r#""count":{count},"componentType":5126,"type":"VEC2","sparse":{{"count":2,
                "indices":{{"bufferView":1,"componentType":5121}},"values":{{"bufferView":0}}}}"#
            );
            let message = read(&accessor, views).unwrap_err();
            assert!(message.contains(wanted), "{message}");
        }
    }
}
