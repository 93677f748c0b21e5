//! Tests of the exploration of shaders.

mod shaderlab {
    mod augmentation;
    mod corpus;
    mod device;
    mod diagnosis;
    mod dialect;
    mod hostile;
    mod membership;
    mod vertex;
    mod volume;

    use relievo_shaderlab::{Augmented, Faults, Language, Shader, Source, Stage};

    /// Reads and augments a fragment shader.
    fn augment(text: &str, language: Language) -> Result<(Shader, Augmented), Faults> {
        let shader = Shader::new(Source::new("test", text, language, Stage::Fragment))?;
        let augmented = shader.augment()?;
        Ok((shader, augmented))
    }

    /// Returns the first fault of a fragment shader: its text, and the bytes that it points at.
    fn fault(text: &str, language: Language) -> (String, String) {
        let faults = augment(text, language).expect_err("a fault");
        let first = &faults.list[0];
        let display = faults.to_string();
        assert!(display.contains(&first.what), "{display}");
        (first.what.clone(), text[first.span.clone()].to_owned())
    }
}
