//! Text and legends drawn into pictures: a swatch and a label per colour, in letters of five by seven dots.

use crate::color::Color;
use crate::image::Image;

/// Dots of a letter, without the gap to the next.
const LETTER: (u32, u32) = (5, 7);
/// The letters from space to underscore in ASCII order; small letters are shown as capitals.
const FIRST: u8 = b' ';
/// The colour of letters on dark ground.
pub(crate) const INK: Color = [0.9; 3];

/// Seven rows of five dots per letter, the leftmost dot in bit 4.
#[rustfmt::skip]
const LETTERS: [[u8; 7]; 64] = [
    [0, 0, 0, 0, 0, 0, 0],                                                              // space
    [0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b00000, 0b00100],                    // !
    [0b01010, 0b01010, 0, 0, 0, 0, 0],                                                  // "
    [0b01010, 0b01010, 0b11111, 0b01010, 0b11111, 0b01010, 0b01010],                    // #
    [0b00100, 0b01111, 0b10100, 0b01110, 0b00101, 0b11110, 0b00100],                    // $
    [0b11000, 0b11001, 0b00010, 0b00100, 0b01000, 0b10011, 0b00011],                    // %
    [0b01100, 0b10010, 0b10100, 0b01000, 0b10101, 0b10010, 0b01101],                    // &
    [0b00100, 0b00100, 0, 0, 0, 0, 0],                                                  // '
    [0b00010, 0b00100, 0b01000, 0b01000, 0b01000, 0b00100, 0b00010],                    // (
    [0b01000, 0b00100, 0b00010, 0b00010, 0b00010, 0b00100, 0b01000],                    // )
    [0b00000, 0b00100, 0b10101, 0b01110, 0b10101, 0b00100, 0b00000],                    // *
    [0b00000, 0b00100, 0b00100, 0b11111, 0b00100, 0b00100, 0b00000],                    // +
    [0b00000, 0b00000, 0b00000, 0b00000, 0b01100, 0b00100, 0b01000],                    // ,
    [0b00000, 0b00000, 0b00000, 0b11111, 0b00000, 0b00000, 0b00000],                    // -
    [0b00000, 0b00000, 0b00000, 0b00000, 0b00000, 0b01100, 0b01100],                    // .
    [0b00001, 0b00001, 0b00010, 0b00100, 0b01000, 0b10000, 0b10000],                    // /
    [0b01110, 0b10001, 0b10011, 0b10101, 0b11001, 0b10001, 0b01110],                    // 0
    [0b00100, 0b01100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110],                    // 1
    [0b01110, 0b10001, 0b00001, 0b00110, 0b01000, 0b10000, 0b11111],                    // 2
    [0b11111, 0b00010, 0b00100, 0b00010, 0b00001, 0b10001, 0b01110],                    // 3
    [0b00010, 0b00110, 0b01010, 0b10010, 0b11111, 0b00010, 0b00010],                    // 4
    [0b11111, 0b10000, 0b11110, 0b00001, 0b00001, 0b10001, 0b01110],                    // 5
    [0b00110, 0b01000, 0b10000, 0b11110, 0b10001, 0b10001, 0b01110],                    // 6
    [0b11111, 0b00001, 0b00010, 0b00100, 0b01000, 0b01000, 0b01000],                    // 7
    [0b01110, 0b10001, 0b10001, 0b01110, 0b10001, 0b10001, 0b01110],                    // 8
    [0b01110, 0b10001, 0b10001, 0b01111, 0b00001, 0b00010, 0b01100],                    // 9
    [0b00000, 0b01100, 0b01100, 0b00000, 0b01100, 0b01100, 0b00000],                    // :
    [0b00000, 0b01100, 0b01100, 0b00000, 0b01100, 0b00100, 0b01000],                    // ;
    [0b00010, 0b00100, 0b01000, 0b10000, 0b01000, 0b00100, 0b00010],                    // <
    [0b00000, 0b00000, 0b11111, 0b00000, 0b11111, 0b00000, 0b00000],                    // =
    [0b01000, 0b00100, 0b00010, 0b00001, 0b00010, 0b00100, 0b01000],                    // >
    [0b01110, 0b10001, 0b00001, 0b00010, 0b00100, 0b00000, 0b00100],                    // ?
    [0b01110, 0b10001, 0b10111, 0b10101, 0b10110, 0b10000, 0b01111],                    // @
    [0b01110, 0b10001, 0b10001, 0b11111, 0b10001, 0b10001, 0b10001],                    // A
    [0b11110, 0b10001, 0b10001, 0b11110, 0b10001, 0b10001, 0b11110],                    // B
    [0b01110, 0b10001, 0b10000, 0b10000, 0b10000, 0b10001, 0b01110],                    // C
    [0b11100, 0b10010, 0b10001, 0b10001, 0b10001, 0b10010, 0b11100],                    // D
    [0b11111, 0b10000, 0b10000, 0b11110, 0b10000, 0b10000, 0b11111],                    // E
    [0b11111, 0b10000, 0b10000, 0b11110, 0b10000, 0b10000, 0b10000],                    // F
    [0b01110, 0b10001, 0b10000, 0b10111, 0b10001, 0b10001, 0b01111],                    // G
    [0b10001, 0b10001, 0b10001, 0b11111, 0b10001, 0b10001, 0b10001],                    // H
    [0b01110, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b01110],                    // I
    [0b00111, 0b00010, 0b00010, 0b00010, 0b00010, 0b10010, 0b01100],                    // J
    [0b10001, 0b10010, 0b10100, 0b11000, 0b10100, 0b10010, 0b10001],                    // K
    [0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b10000, 0b11111],                    // L
    [0b10001, 0b11011, 0b10101, 0b10101, 0b10001, 0b10001, 0b10001],                    // M
    [0b10001, 0b10001, 0b11001, 0b10101, 0b10011, 0b10001, 0b10001],                    // N
    [0b01110, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01110],                    // O
    [0b11110, 0b10001, 0b10001, 0b11110, 0b10000, 0b10000, 0b10000],                    // P
    [0b01110, 0b10001, 0b10001, 0b10001, 0b10101, 0b10010, 0b01101],                    // Q
    [0b11110, 0b10001, 0b10001, 0b11110, 0b10100, 0b10010, 0b10001],                    // R
    [0b01111, 0b10000, 0b10000, 0b01110, 0b00001, 0b00001, 0b11110],                    // S
    [0b11111, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100, 0b00100],                    // T
    [0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01110],                    // U
    [0b10001, 0b10001, 0b10001, 0b10001, 0b10001, 0b01010, 0b00100],                    // V
    [0b10001, 0b10001, 0b10001, 0b10101, 0b10101, 0b10101, 0b01010],                    // W
    [0b10001, 0b10001, 0b01010, 0b00100, 0b01010, 0b10001, 0b10001],                    // X
    [0b10001, 0b10001, 0b10001, 0b01010, 0b00100, 0b00100, 0b00100],                    // Y
    [0b11111, 0b00001, 0b00010, 0b00100, 0b01000, 0b10000, 0b11111],                    // Z
    [0b01110, 0b01000, 0b01000, 0b01000, 0b01000, 0b01000, 0b01110],                    // [
    [0b10000, 0b10000, 0b01000, 0b00100, 0b00010, 0b00001, 0b00001],                    // \
    [0b01110, 0b00010, 0b00010, 0b00010, 0b00010, 0b00010, 0b01110],                    // ]
    [0b00100, 0b01010, 0b10001, 0, 0, 0, 0],                                            // ^
    [0b00000, 0b00000, 0b00000, 0b00000, 0b00000, 0b00000, 0b11111],                    // _
];

/// Draws a legend into the bottom left corner of a colour picture: one line per entry, as many as fit. Dots grow with
/// the picture, so that the letters stay readable.
pub fn draw_legend(image: &mut Image, entries: &[(Color, &str)]) {
    if entries.is_empty() || image.channels() < 3 {
        return;
    }
    let dot = (image.height() / 360).max(1);
    let (margin, line) = (4 * dot, 10 * dot);
    let lines = (image.height().saturating_sub(4 * margin) / line).min(entries.len() as u32);
    let longest = entries.iter().map(|(_, label)| label.chars().count() as u32).max().unwrap_or(0);
    let width = (12 * dot + longest * (LETTER.0 + 1) * dot + 2 * margin).min(image.width().saturating_sub(2 * margin));
    let top = image.height().saturating_sub(lines * line + 3 * margin);
    let (left, right) = (margin, margin + width);
    // A dark panel, through which the picture shines a little.
    for y in top..(top + lines * line + 2 * margin).min(image.height()) {
        for x in left..right {
            let dimmed = image.color(x, y).map(|value| 0.12 * value.clamp(0.0, 1.0));
            image.set_color(x, y, dimmed);
        }
    }
    for (row, (color, label)) in (0..lines).zip(entries) {
        let y = top + margin + row * line;
        fill(image, [left + margin, y, 8 * dot, 7 * dot], *color);
        let place = [left + margin + 12 * dot, y];
        draw_text(image, place, dot, right.saturating_sub(margin), INK, label);
    }
}

/// Draws a line of text into a picture of colours, whose top left corner is at (x, y) in pixels, in letters of five by seven
/// dots of `dot` pixels with a gap of one, as much of it as ends before `right`. Small letters are shown as capitals.
pub fn draw_text(image: &mut Image, [mut x, y]: [u32; 2], dot: u32, right: u32, color: Color, text: &str) {
    for letter in text.chars() {
        if x + LETTER.0 * dot > right {
            break;
        }
        draw_letter(image, [x, y], dot, color, letter);
        x += (LETTER.0 + 1) * dot;
    }
}

fn draw_letter(image: &mut Image, [x, y]: [u32; 2], dot: u32, color: Color, letter: char) {
    let code = u8::try_from(letter.to_ascii_uppercase()).unwrap_or(b'?');
    let unknown = (b'?' - FIRST) as usize;
    let rows = LETTERS.get(usize::from(code).wrapping_sub(usize::from(FIRST))).unwrap_or(&LETTERS[unknown]);
    for (row, dots) in (0..LETTER.1).zip(rows) {
        for column in (0..LETTER.0).filter(|column| dots >> (LETTER.0 - 1 - column) & 1 == 1) {
            fill(image, [x + column * dot, y + row * dot, dot, dot], color);
        }
    }
}

/// Fills the rectangle [left, top, width, height].
fn fill(image: &mut Image, [left, top, width, height]: [u32; 4], color: Color) {
    for y in top..top + height {
        for x in left..left + width {
            image.set_color(x, y, color);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn letters_are_inside_their_cell_and_differ() {
        assert!(LETTERS.iter().flatten().all(|row| *row < 32));
        assert_eq!(LETTERS.iter().collect::<BTreeSet<_>>().len(), LETTERS.len());
    }

    #[test]
    fn swatches_have_their_colour_and_labels_their_dots() {
        let mut image = Image::new(200, 100, 3).unwrap();
        let (red, blue) = ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
        draw_legend(&mut image, &[(red, "T"), (blue, "unallocated")]);
        let count = |image: &Image, color: Color| {
            (0..100).flat_map(|y| (0..200).map(move |x| (x, y))).filter(|(x, y)| image.color(*x, *y) == color).count()
        };
        assert_eq!((count(&image, red), count(&image, blue)), (56, 56));
        let dots = |letter: u8| LETTERS[usize::from(letter - FIRST)].iter().map(|row| row.count_ones()).sum::<u32>();
        let expected: u32 = b"TUNALLOCATED".iter().map(|letter| dots(*letter)).sum();
        assert_eq!(count(&image, INK), expected as usize);
    }

    #[test]
    fn nothing_happens_where_there_is_no_room() {
        for size in [1, 5, 20] {
            let mut image = Image::new(size, size, 3).unwrap();
            draw_legend(&mut image, &[([1.0; 3], "a long label \u{4e2d}"), ([0.5; 3], "")]);
        }
        let mut grey = Image::new(50, 50, 1).unwrap();
        draw_legend(&mut grey, &[([1.0; 3], "grey")]);
        assert!(grey.data().iter().all(|value| *value == 0.0));
    }
}
