// COLLADA: fields of view, and what else Assimp's reader does not accept.
#include "import_support.h"
#include "tests/support/scene_files.h"

#include "scene/default_view.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

namespace clerestory::test {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

Scene withCamera(const std::string& perspective) {
    const TemporaryFolder folder;
    return importScene(folder.write("camera.dae", triangleDae(perspective)));
}

// Whole angles in degrees. With both, or with one and the aspect ratio, the vertical one follows;
// alone, yfov is vertical, and xfov is that of a square picture.
TEST(Collada, FieldsOfViewAreDegreesOfTheWholeAngle) {
    const double narrow = 2.0 * std::atan(std::tan(25.0 * kDegree) / 1.5);
    const struct {
        const char* optics;
        double yfov;
    } rows[] = {
        {"<yfov>37.8492</yfov>", 37.8492 * kDegree},
        {"<yfov>37.8492</yfov><aspect_ratio>1.5</aspect_ratio>", 37.8492 * kDegree},
        {"<yfov>80</yfov><aspect_ratio>0.5</aspect_ratio>", 80.0 * kDegree},
        {"<xfov>50</xfov><aspect_ratio>1.5</aspect_ratio>", narrow},
        {"<xfov>50</xfov><yfov>37.8492</yfov>", 37.8492 * kDegree},
        {"<yfov> 37.8492</yfov>", 37.8492 * kDegree},
    };
    for (const auto& row : rows) {
        const Scene scene =
            withCamera(row.optics + std::string("<znear>1</znear><zfar>100</zfar>"));
        ASSERT_EQ(scene.cameras.size(), 1u) << row.optics;
        EXPECT_NEAR(scene.cameras[0].yfov, row.yfov, 1e-5) << row.optics;
        const DefaultView view = defaultView(scene);
        EXPECT_NEAR(view.yfov, row.yfov, 1e-5) << row.optics;
        EXPECT_NEAR(glm::distance(view.position, glm::dvec3(0, 0, 4)), 0.0, 1e-6) << row.optics;
    }
}

// Cameras or lights alone are no picture. Assimp would draw a spike for each node.
TEST(Collada, FilesWithoutMeshesAreUnsupported) {
    std::string cameras = triangleDae("<yfov>40</yfov>");
    const std::string mesh = R"(<instance_geometry url="#g"/>)";
    cameras.erase(cameras.find(mesh), mesh.size());
    const std::size_t first = cameras.find("<library_geometries>"),
                      end = cameras.find("</library_geometries>");
    cameras.erase(first, end + std::string("</library_geometries>").size() - first);
    const TemporaryFolder folder;
    const ImportError error = refusal(folder.write("cameras.dae", cameras));
    EXPECT_EQ(error.reason(), ImportError::Reason::unsupported) << error.what();
    EXPECT_THAT(error.what(), testing::HasSubstr("no triangles, lines or points"));
}

}  // namespace
}  // namespace clerestory::test
