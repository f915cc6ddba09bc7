// A triangle outside the clip volume: the driver prepares all state for it and shades no pixel.
void main() {
    gl_Position = vec4(2.0f, 2.0f, 2.0f, 1.0f);
}
