//! The membership against its closed form, and the text of classes.

use proptest::prelude::*;
use relievo_shaderlab::{
    Class, Classes, Example, Language, Shader, Source, Stage, Transfer, membership, membership_function,
};

/// Equation 2 in f64, as the paper states it.
fn closed_form(vector: &[f32], examples: &[(f32, Vec<f32>)], exponent: f64) -> f64 {
    let mut sums = [0.0, 0.0];
    for (class, example) in examples {
        let square: f64 = vector.iter().zip(example).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum();
        let weight = 1.0 / square.sqrt().powf(exponent);
        sums = [sums[0] + f64::from(*class) * weight, sums[1] + weight];
    }
    sums[0] / sums[1]
}

fn of(vector: &[f32], examples: &[(f32, Vec<f32>)], exponent: f32) -> f32 {
    let factors = vec![1.0; vector.len()];
    membership(vector, examples.iter().map(|(class, example)| (*class, example.as_slice())), &factors, exponent)
}

proptest! {
    #[test]
    fn it_is_equation_2(
        vector in prop::collection::vec(-4.0_f32..4.0, 3),
        examples in prop::collection::vec((prop::bool::ANY, prop::collection::vec(-4.0_f32..4.0, 3)), 1..9),
        exponent in 0.25_f32..8.0,
    ) {
        let examples: Vec<_> = examples.into_iter().map(|(class, it)| (f32::from(u8::from(class)), it)).collect();
        let near = examples.iter().any(|(_, it)| it.iter().zip(&vector).all(|(a, b)| (a - b).abs() < 1e-3));
        prop_assume!(!near);
        let expected = closed_form(&vector, &examples, f64::from(exponent));
        let found = f64::from(of(&vector, &examples, exponent));
        prop_assert!((found - expected).abs() < 2e-4, "{found} is not {expected}");
        // The order of examples does not matter.
        let mut turned = examples.clone();
        turned.reverse();
        prop_assert!((f64::from(of(&vector, &turned, exponent)) - expected).abs() < 2e-4);
    }

    #[test]
    fn it_stays_between_0_and_1(
        vector in prop::collection::vec(prop::num::f32::ANY, 2),
        examples in prop::collection::vec((prop::bool::ANY, prop::collection::vec(prop::num::f32::NORMAL, 2)), 0..6),
        exponent in 0.01_f32..64.0,
    ) {
        let examples: Vec<_> = examples.into_iter().map(|(class, it)| (f32::from(u8::from(class)), it)).collect();
        let found = of(&vector, &examples, exponent);
        prop_assert!((0.0..=1.0).contains(&found), "{found}");
    }
}

#[test]
fn hits_are_exact_and_nothing_classified_is_a_half() {
    let examples = vec![(1.0, vec![1.0, 2.0]), (0.0, vec![3.0, 4.0]), (0.0, vec![1.0, 2.0])];
    assert_eq!(of(&[3.0, 4.0], &examples, 5.0), 0.0);
    assert_eq!(of(&[1.0, 2.0], &examples, 5.0), 0.5);
    assert_eq!(of(&[1.0, 2.0], &examples[..2], 5.0), 1.0);
    assert_eq!(of(&[7.0, 7.0], &[], 5.0), 0.5);
    assert_eq!(of(&[f32::NAN, 0.0], &examples, 1.0), 0.5);
    // Equation 2 itself overflows here.
    assert_eq!(of(&[1.0 + f32::EPSILON, 2.0], &examples[..2], 64.0), 1.0);
    assert!((of(&[2.0, 3.0], &examples[..2], 3.0) - 0.5).abs() < 1e-6);
}

fn classes() -> Classes {
    let mut classes = Classes::new(vec!["a".into(), "b".into()]);
    let example = |class, vector: [f32; 2]| Example { pixel: [1, 2], class, vector: vector.to_vec() };
    classes.examples = vec![
        example(Class::Positive, [0.25, 100.0]),
        example(Class::Negative, [0.75, 300.0]),
        example(Class::Negative, [0.1, 220.0]),
    ];
    classes
}

#[test]
fn classes_survive_their_file() {
    let classes = classes();
    let text = classes.to_json().unwrap();
    assert_eq!(Classes::from_json(&text).unwrap(), classes);
    for end in 0..text.trim_end().len() {
        assert!(Classes::from_json(&text[..end]).is_err());
    }
    assert!(Classes::from_json(&text.replace("\"version\": 1", "\"version\": 2")).is_err());
    assert!(Classes::from_json(&text.replace("0.75", "1e99")).is_err());
    let mut wrong = classes.clone();
    wrong.examples[0].vector.pop();
    assert!(wrong.check().is_err());
    wrong = classes;
    wrong.exponent = f32::NAN;
    assert!(wrong.check().is_err());
}

#[test]
fn scaling_gives_every_feature_the_same_weight() {
    let mut classes = classes();
    assert_eq!(classes.factors(), [1.0, 1.0]);
    classes.is_scaled = true;
    let factors = classes.factors();
    assert!((factors[0] - 1.0 / 0.65).abs() < 1e-5 && (factors[1] - 1.0 / 200.0).abs() < 1e-7);
}

#[test]
fn a_transfer_function_is_the_membership() {
    let classes = classes();
    let transfer = Transfer::new(&classes, [0, 1], Some([[0.0, 1.0], [0.0, 400.0]])).unwrap();
    let image = transfer.image(8, 4).unwrap();
    for (x, y) in [(0, 0), (2, 2), (7, 3)] {
        let at = [(x as f32 + 0.5) / 8.0, (3.5 - y as f32) / 4.0 * 400.0];
        assert!((image.pixel(x, y)[0] - classes.membership(&at)).abs() < 1e-5);
    }
    let wgsl = membership_function(&classes, Language::Wgsl, "vessel").unwrap();
    let wgsl = format!("{wgsl}@fragment fn fs() -> @location(0) vec4<f32> {{ return vec4<f32>(vessel(1.0, 2.0)); }}");
    let glsl = membership_function(&classes, Language::Glsl, "vessel").unwrap();
    let glsl =
        format!("#version 450\nlayout(location = 0) out vec4 c;\n{glsl}void main() {{ c = vec4(vessel(1.0, 2.0)); }}");
    for (text, language) in [(wgsl, Language::Wgsl), (glsl, Language::Glsl)] {
        Shader::new(Source::new("test", text, language, Stage::Fragment)).unwrap_or_else(|faults| panic!("{faults}"));
    }
    assert!(membership_function(&classes, Language::Wgsl, "a b").is_err());
    assert!(Transfer::new(&classes, [0, 0], None).is_err() && Transfer::new(&classes, [0, 2], None).is_err());
}
