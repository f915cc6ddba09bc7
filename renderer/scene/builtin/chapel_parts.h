// Dimensions and parts of the chapel, for the chapel's sources only. The nave extends along Z from
// the door at +kLength/2 to the altar at -kLength/2; +Y is up, the floor is y = 0. Metres.
#pragma once

#include "scene/builtin/modelling.h"

namespace clerestory::chapel_parts {

inline constexpr int kBays = 6;
inline constexpr float kBay = 4.0f;
inline constexpr float kLength = kBays * kBay;
inline constexpr float kColumn = 3.6f;   // from the middle to the columns' axes
inline constexpr float kWall = 0.3f;     // half the thickness of the wall they carry
inline constexpr float kAisle = 6.6f;    // from the middle to the outer walls
inline constexpr float kCapital = 4.2f;  // height of the columns
inline constexpr float kVault = 10.4f;   // where the vault springs
inline constexpr float kAisleVault = 6.7f;
inline constexpr float kOuterWall = 0.35f;  // thickness of the outer walls
inline constexpr int kDoorBay = 3;          // the open door in the aisle at +X
inline constexpr float kDoorZ = (static_cast<float>(kDoorBay) + 0.5f) * kBay - 0.5f * kLength;

struct Materials {
    Index stone, dressedStone, floor, wood, brass, iron, gold, ember, flame, wax, cloth, glassBall,
        paving, leaves;
    Index lancets[3], rose;
};
Materials addMaterials(Scene& scene);

// Half width of a pointed arch is `half`, its two circles have radius `radius` >= half; the height
// over the springing line at x, |x| <= half.
float pointedArch(float x, float half, float radius);

// A hole in a wall: u along the wall, y up.
struct Opening {
    float center, half;
    float bottom;         // y of the sill (of the lowest point, for a circle)
    float spring;         // y where the arch begins; for a circle, its centre
    float radius;         // of the arch's circles; 0: a circle of radius `half`
    Index glass = kNone;  // kNone: an open arch
    float lower(float u) const;
    float upper(float u) const;
};

void addMasonry(Scene& scene, const Materials& materials);
void addOutside(Scene& scene, const Materials& materials);
void addFurniture(Scene& scene, const Materials& materials);
void addLights(Scene& scene);

}  // namespace clerestory::chapel_parts
