#version 450
// A terrain of 96 by 96 squares, made of the index of the vertex. Its vertices take vectors of height and slope, and what
// resembles the positive examples is blue.

layout(set = 0, binding = 0) uniform View {
    float turn;   // radians, around the vertical axis
    float tilt;   // radians, from the horizon down
    float aspect; // width over height of the picture
};

layout(location = 0) out vec3 color;

const int SQUARES = 96;

float relief(vec2 at) {
    float ridge = 0.22 * sin(3.1 * at.x + 1.3 * at.y) * cos(2.3 * at.y - 0.7);
    float hill = 0.3 * exp(-6.0 * dot(at - vec2(0.3, -0.2), at - vec2(0.3, -0.2)));
    float bumps = 0.02 * sin(17.0 * at.x) * sin(13.0 * at.y + 2.0 * at.x);
    return ridge + hill + bumps;
}

void main() {
    int square = gl_VertexIndex / 6;
    int corner = gl_VertexIndex % 6;
    int right = corner == 1 || corner == 2 || corner == 4 ? 1 : 0;
    int up = corner == 2 || corner == 4 || corner == 5 ? 1 : 0;
    vec2 cell = vec2(float(square % SQUARES + right), float(square / SQUARES + up));
    vec2 at = 2.0 * cell / float(SQUARES) - 1.0;

    //. name Height
    float height = relief(at);
    const float STEP = 0.002;
    vec2 rise = vec2(relief(at + vec2(STEP, 0.0)) - height, relief(at + vec2(0.0, STEP)) - height) / STEP;
    //. name Slope
    float slope = length(rise);
    //. vector height; slope; 1.0

    vec3 normal = normalize(vec3(-rise, 1.0));
    float light = 0.15 + 0.7 * max(dot(normal, normalize(vec3(-0.6, 0.3, 0.7))), 0.0);
    color = light * mix(vec3(0.9, 0.85, 0.75), vec3(0.05, 0.3, 0.9), 0.0 /*. + confidence */);

    vec2 turned = vec2(cos(turn) * at.x - sin(turn) * at.y, sin(turn) * at.x + cos(turn) * at.y);
    float across = 2.2 * turned.x;
    float above = 2.2 * (height * cos(tilt) + turned.y * sin(tilt)) + 0.3;
    float away = 3.2 + turned.y * cos(tilt) - height * sin(tilt);
    const float NEAR = 1.0;
    const float FAR = 6.0;
    gl_Position = vec4(across / aspect, above, (away - NEAR) * FAR / (FAR - NEAR), away);
}
