// Transmittance of glass for light that passes it without refraction: shadows and gathered light.
#include "ray_room.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace clerestory;
using namespace clerestory::rays;

namespace {

constexpr double kIor = 1.5, kThickness = 0.2, kDistance = 0.3;
const glm::dvec3 kTint(0.9, 0.6, 1.0), kAttenuation(0.2, 0.5, 0.8);

// Its front is towards -Z, or +Z.
void addSheet(RayRoom& room, float z, bool towardsPlus) {
    const glm::vec3 left(-50.0f, -50.0f, z), right(50.0f, -50.0f, z);
    room.add(towardsPlus ? left : right, towardsPlus ? right : left, {0.0f, 50.0f, z});
}

void setGlass(RayRoom& room, int kind) {
    room.materialRow(0) = glm::vec4(kTint, 1.0f);
    room.materialRow(3).w = 1.0f;  // full reflection at the faces
    room.materialRow(4) = {1.0f, kIor, kThickness, kDistance};
    room.materialRow(5) = glm::vec4(kAttenuation, float(kind | TRACE_DOUBLE_SIDED));
}

// Fresnel's equations for light without polarisation.
double fresnel(double cosine) {
    const double inside = std::sqrt(1.0 - (1.0 - cosine * cosine) / (kIor * kIor));
    const double s = (cosine - kIor * inside) / (cosine + kIor * inside);
    const double p = (kIor * cosine - inside) / (kIor * cosine + inside);
    return 0.5 * (s * s + p * p);
}

glm::vec3 inclined(double degrees) {
    const double angle = glm::radians(degrees);
    return {std::sin(angle), 0.0, std::cos(angle)};
}

TEST(RayGlass, ABodyAbsorbsAlongTheStraightWayThroughIt) {
    RayRoom room(0.0f);
    setGlass(room, TRACE_SOLID);
    addSheet(room, 1.0f, false);
    addSheet(room, 1.0f + float(kThickness), true);
    const Surroundings around = room.surroundings(glm::vec3(0.0f));
    const PathTracer tracer(around);
    for (const double degrees : {0.0, 30.0, 60.0}) {
        const glm::vec3 along = inclined(degrees);
        const double cosine = std::cos(glm::radians(degrees)), faces = 1.0 - fresnel(cosine);
        const SurfaceHit through = tracer.surfaceAlong(glm::vec3(0.0f), along, 0.0f, 0.0f);
        ASSERT_FALSE(through.met) << degrees;
        // From the middle of the body only the second half absorbs, and one face reflects.
        const glm::vec3 middle(0.0f, 0.0f, 1.0f + 0.5f * float(kThickness));
        const SurfaceHit leaving = tracer.surfaceAlong(middle, along, 0.0f, 0.0f);
        for (int c = 0; c < 3; ++c) {
            const double left = std::pow(kAttenuation[c], kThickness / cosine / kDistance);
            EXPECT_NEAR(through.share[c], kTint[c] * faces * faces * left, 2e-3) << degrees;
            EXPECT_NEAR(leaving.share[c], faces * std::sqrt(left), 2e-3) << degrees;
        }
    }
}

// The series of all bounces between the faces, by summation.
TEST(RayGlass, APaneAbsorbsAlongItsRefractedWay) {
    RayRoom room(0.0f);
    setGlass(room, TRACE_PANE);
    addSheet(room, 1.0f, false);
    const Surroundings around = room.surroundings(glm::vec3(0.0f));
    const PathTracer tracer(around);
    for (const double degrees : {0.0, 30.0, 60.0}) {
        const double cosine = std::cos(glm::radians(degrees)), f = fresnel(cosine);
        const double inside = std::sqrt(1.0 - (1.0 - cosine * cosine) / (kIor * kIor));
        const SurfaceHit through =
            tracer.surfaceAlong(glm::vec3(0.0f), inclined(degrees), 0.0f, 0.0f);
        ASSERT_FALSE(through.met) << degrees;
        for (int c = 0; c < 3; ++c) {
            const double a = std::pow(kAttenuation[c], kThickness / inside / kDistance);
            double expected = 0.0, bounced = (1.0 - f) * (1.0 - f) * a;
            for (int i = 0; i < 50; ++i, bounced *= f * f * a * a) expected += bounced;
            EXPECT_NEAR(through.share[c], kTint[c] * expected, 2e-3) << degrees;
        }
    }
}

}  // namespace
