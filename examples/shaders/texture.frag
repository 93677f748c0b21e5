// Shows a texture. The membership of a texel by its luminance and its place is the opacity.
uniform sampler2D tex;
varying vec2 co;

void main() {
    vec4 color = texture2D(tex, co.st);
    //.vector color.r; co.s; co.t; 1.0
    gl_FragColor = vec4(vec3(color.r),

        1.0 /*. * confidence */);
}
