//! Arrays of two to five, element by element, in kernels.

/// An array whose elements are mapped one after the other, written out.
///
/// `<[T; N]>::map` calls its closure through several functions of the standard library that are not inlined for sure. In
/// a kernel each of them is one without the set's instructions, and three more to compile. So is a closure of several operations that is
/// called more than once: those are functions, `#[inline(always)]`.
pub trait Each<T> {
    /// Array of as many elements.
    type Of<U>;
    /// Returns `of` of each element, the first one first.
    fn each<U>(self, of: impl FnMut(T) -> U) -> Self::Of<U>;
}

macro_rules! each {
    ($count:literal: $($element:ident)+) => {
        impl<T> Each<T> for [T; $count] {
            type Of<U> = [U; $count];
            #[inline(always)]
            fn each<U>(self, mut of: impl FnMut(T) -> U) -> [U; $count] {
                let [$($element),+] = self;
                [$(of($element)),+]
            }
        }
    };
}
each!(2: a b);
each!(3: a b c);
each!(4: a b c d);
each!(5: a b c d e);
