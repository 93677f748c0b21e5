#version 450
// A bilateral filter (Tomasi and Manduchi 1998) whose threshold is different for each pixel: edges that resemble the positive
// examples stay, all else is smoothed. The feature is the gradient magnitude by Sobel's operator.
uniform sampler2D photo;
uniform float radius;
uniform float threshold;
uniform vec2 resolution;

layout(location = 0) in vec2 uv;
layout(location = 0) out vec4 color;

float luminance(vec2 place) {
    return dot(texture(photo, place).rgb, vec3(0.2126, 0.7152, 0.0722));
}

float sobel(vec2 place, vec2 texel) {
    float a = luminance(place + texel * vec2(-1.0, -1.0));
    float b = luminance(place + texel * vec2(0.0, -1.0));
    float c = luminance(place + texel * vec2(1.0, -1.0));
    float d = luminance(place + texel * vec2(-1.0, 0.0));
    float f = luminance(place + texel * vec2(1.0, 0.0));
    float g = luminance(place + texel * vec2(-1.0, 1.0));
    float h = luminance(place + texel * vec2(0.0, 1.0));
    float i = luminance(place + texel * vec2(1.0, 1.0));
    return length(vec2(c + 2.0 * f + i - a - 2.0 * d - g, g + 2.0 * h + i - a - 2.0 * b - c));
}

void main() {
    vec2 texel = 1.0 / resolution;
    //. name Edge
    //. desc Gradient magnitude of the luminance
    float edge = sobel(uv, texel);
    //. vector edge; 1.0
    float limit = threshold /*. * 2.0 * (1.0 - confidence) */;
    vec3 centre = texture(photo, uv).rgb;
    vec3 sum = vec3(0.0);
    float total = 0.0;
    for (float y = -radius; y <= radius; y += 1.0) {
        for (float x = -radius; x <= radius; x += 1.0) {
            vec3 other = texture(photo, uv + texel * vec2(x, y)).rgb;
            float apart = distance(other, centre);
            float weight = exp(-2.0 * (x * x + y * y) / (radius * radius));
            weight *= apart <= limit ? 1.0 : 0.0;
            sum += weight * other;
            total += weight;
        }
    }
    color = vec4(sum / max(total, 1e-6), 1.0);
}
