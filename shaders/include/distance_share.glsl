// Beside its colour a picture of the scene keeps how far away each pixel is, as a share of the scene's
// diagonal: the half float's digits are then spent alike on scenes of any size.

// The sky, and whatever is farther than anything in the scene can be from its middle.
const float kFarShare = 16.0f;

float distanceShare(float metres, float inverseDiagonal) {
    return clamp(metres * inverseDiagonal, 0.0f, kFarShare);
}

// Of a picture that is blurred: falls with the distance, so that near things count in a mean with the sky.
// Greater than any distance share.
float asInverse(float share) {
    return kFarShare + kFarShare / max(share, 3e-4f);  // finite as a half
}
// The share of either.
float shareStored(float stored) {
    float inverse = stored - kFarShare;
    return inverse > 0.0f ? min(kFarShare / inverse, kFarShare) : stored;
}
