// Where a vertex lands. Depth and surface programs share these lines and declare gl_Position
// invariant: a pixel is shaded where its depth equals the one drawn first, bit for bit.

layout(location = ATTRIBUTE_POSITION) in vec3 position;
layout(location = ATTRIBUTE_EYE_FROM_MODEL) in vec4 eyeFromModel[3];  // rows

invariant gl_Position;

// Clips where the pass enables it, because its view has a clip plane. Written in every view, so that
// mirrored views share their programs with all others.
void clipAt(vec3 positionEye) {
    gl_ClipDistance[0] = dot(view.clipPlane.xyz, positionEye) + view.clipPlane.w;
}

vec3 eyePosition() {
    vec4 p = vec4(position, 1.0f);
    return vec3(dot(eyeFromModel[0], p), dot(eyeFromModel[1], p), dot(eyeFromModel[2], p));
}

vec4 clipPosition(vec3 positionEye) {
    return view.clipFromEye * vec4(positionEye, 1.0f);
}
