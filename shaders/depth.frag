// Depth alone: fixed function writes it.
void main() {}
