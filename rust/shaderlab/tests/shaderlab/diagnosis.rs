//! Diagnosis of classes whose structure is known.

use relievo_shaderlab::{Class, Classes, Diagnosis, Example, Explanation};

/// Classes that the first feature separates; the second one is a multiple of it, the third one is noise.
fn classes() -> Classes {
    let mut classes = Classes::new(vec!["density".into(), "double".into(), "noise".into()]);
    for index in 0..8_u32 {
        let is_positive = index % 2 == 0;
        let density = if is_positive { 1.0 } else { 0.0 } + 0.01 * index as f32;
        let noise = [0.3, 0.31, 0.7, 0.69, 0.1, 0.12, 0.9, 0.88][index as usize];
        let class = if is_positive { Class::Positive } else { Class::Negative };
        classes.examples.push(Example { pixel: [index, 0], class, vector: vec![density, 2.0 * density, noise] });
    }
    classes
}

#[test]
fn correlated_and_redundant_features_are_found() {
    let diagnosis = Diagnosis::of(&classes(), &[]);
    assert_eq!(diagnosis.error, Some(0.0));
    assert_eq!(diagnosis.correlations.len(), 1);
    assert_eq!(diagnosis.correlations[0].features, [0, 1]);
    assert!((diagnosis.correlations[0].coefficient - 1.0).abs() < 1e-6);
    assert_eq!(diagnosis.redundant, Some(1));
    assert_eq!(diagnosis.errors_without.len(), 3);
}

#[test]
fn classes_that_overlap_have_an_error() {
    let mut noise = classes();
    noise.features = vec!["noise".into()];
    noise.examples.iter_mut().for_each(|example| example.vector = vec![example.vector[2]]);
    let diagnosis = Diagnosis::of(&noise, &[]);
    assert_eq!(diagnosis.error, Some(1.0));
    assert!(diagnosis.errors_without.is_empty() && diagnosis.redundant.is_none());
    let empty = Diagnosis::of(&Classes::new(vec!["a".into(), "b".into()]), &[vec![1.0, 2.0]]);
    assert_eq!((empty.error, empty.redundant), (None, None));
}

#[test]
fn a_pixel_is_explained_by_the_nearest_example_and_the_feature_that_decides() {
    let classes = classes();
    let explanation = Explanation::of(&classes, &[1.0, 2.0, 0.5]);
    assert!(explanation.membership > 0.5);
    assert_eq!(classes.examples[explanation.neighbours[0].example].class, Class::Positive);
    assert!(explanation.neighbours.windows(2).all(|pair| pair[0].distance <= pair[1].distance));
    assert!((explanation.neighbours.iter().map(|it| it.share).sum::<f64>() - 1.0).abs() < 1e-9);
    assert_eq!(explanation.deciding, Some(1));
    assert_eq!(Explanation::of(&Classes::new(vec!["a".into()]), &[1.0]).neighbours, []);
}
