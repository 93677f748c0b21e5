//! The glossy part of what surfaces reflect.

use glam::Vec3;

use crate::scene::Material;

/// The GGX lobe with Schlick's Fresnel term and the height-correlated shadowing of Smith.
pub(crate) fn gloss(material: &Material, normal: Vec3, toward: Vec3, to_eye: Vec3) -> Vec3 {
    let (specular, roughness) = (material.specular, material.roughness);
    let (light, eye) = (normal.dot(toward), normal.dot(to_eye));
    let half = (toward + to_eye).normalize_or_zero();
    if specular <= 0.0 || light <= 0.0 || eye <= 0.0 {
        return Vec3::ZERO;
    }
    let alpha2 = roughness.max(0.05).powi(4);
    let cos = normal.dot(half).clamp(0.0, 1.0);
    let spread = cos * cos * (alpha2 - 1.0) + 1.0;
    let density = alpha2 / (std::f32::consts::PI * spread * spread);
    let smith = |cos: f32, other: f32| other * (alpha2 + (1.0 - alpha2) * cos * cos).sqrt();
    let visible = 0.5 / (smith(light, eye) + smith(eye, light)).max(1e-6);
    let fresnel = specular + (1.0 - specular) * (1.0 - half.dot(to_eye).clamp(0.0, 1.0)).powi(5);
    Vec3::splat(density * visible * fresnel)
}
