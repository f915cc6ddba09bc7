// Beside its colour a picture of the scene keeps how far away each pixel is, as a share of the scene's
// diagonal: the half float's digits are then spent alike on scenes of any size.

// The sky, and whatever is farther than anything in the scene can be from its middle.
const float kFarShare = 16.0f;

float distanceShare(float metres, float perMetre) {
    return clamp(metres * perMetre, 0.0f, kFarShare);
}
