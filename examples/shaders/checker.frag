// Squares of four shades, as Shadertoy has its shaders.
void mainImage(out vec4 fragColor, in vec2 fragCoord) {
    vec2 square = floor(4.0 * fragCoord / iResolution.xy);
    float shade = mod(square.x + square.y, 2.0) * (0.4 + 0.2 * square.y);
    fragColor = vec4(vec3(shade), 1.0);
}
