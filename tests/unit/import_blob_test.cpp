// The blob between the two processes: complete, or an exception.
#include "scene/import/cache/blob.h"
#include "tests/unit/import_support.h"

namespace clerestory {
namespace {

std::vector<std::byte> blobOf(const Scene& scene) {
    std::vector<std::byte> blob;
    writeScene(scene, [&](const void* bytes, std::size_t count) {
        const auto* from = static_cast<const std::byte*>(bytes);
        blob.insert(blob.end(), from, from + count);
    });
    return blob;
}

Scene sample() {
    Scene scene = importSceneInProcess(ownScene("everything.gltf"));
    scene.id = "sample";
    scene.environment = "dusk";
    scene.defaultView = DefaultView{{1, 2, 3}, {4, 5, 6}, 0.5};
    Material& m = scene.materials.at(0);
    m.reflection = Reflection::mirror;
    m.probe = "middle";
    m.environmentMap = "dusk";
    m.environmentRotation = {0.8, 0.0, 0.6, 0.0};
    scene.probes.push_back({"middle", 0, {1, 2, 3}, 0.5, 64, 100.0});
    updateContentHash(scene);
    return scene;
}

TEST(SceneBlob, RoundTripPreservesEverything) {
    const Scene scene = sample();
    Scene back = readScene(blobOf(scene));
    EXPECT_EQ(back.id, "sample");
    EXPECT_EQ(back.title, scene.title);
    EXPECT_EQ(back.contentHash, scene.contentHash);
    EXPECT_EQ(back.environment, "dusk");
    ASSERT_TRUE(back.defaultView);
    EXPECT_EQ(back.defaultView->target, glm::dvec3(4, 5, 6));
    EXPECT_EQ(back.warnings.size(), scene.warnings.size());
    EXPECT_EQ(back.cameras.size(), 2u);
    EXPECT_FALSE(back.flatParts.empty());
    EXPECT_EQ(back.images.at(0).mean, scene.images.at(0).mean);
    EXPECT_EQ(back.images.at(0).texels, scene.images.at(0).texels);
    updateContentHash(back);
    EXPECT_EQ(back.contentHash, scene.contentHash) << "the content changed";
    EXPECT_EQ(blobOf(back), blobOf(scene));
}

TEST(SceneBlob, EmptyScenesRoundTrip) {
    EXPECT_TRUE(readScene(blobOf(Scene{})).meshes.empty());
}

TEST(SceneBlob, TruncatedBlobsAreRejected) {
    const std::vector<std::byte> blob = blobOf(sample());
    for (std::size_t length = 0; length < blob.size(); length += length < 400 ? 1 : 37) {
        EXPECT_THROW(readScene(std::span(blob).first(length)), BlobError) << length;
    }
    std::vector<std::byte> longer = blob;
    longer.push_back(std::byte{0});
    EXPECT_THROW(readScene(longer), BlobError);
}

// In pieces, and never beyond its end.
TEST(SceneBlob, ASourceIsReadOnce) {
    const std::vector<std::byte> blob = blobOf(sample());
    std::size_t at = 0, pieces = 0, failAt = blob.size() + 1;
    const BlobSource source = [&](void* to, std::size_t count) {
        ASSERT_LE(at + count, blob.size());
        if (at + count > failAt) throw BlobError("the disk fails");
        std::copy_n(blob.data() + at, count, static_cast<std::byte*>(to));
        at += count;
        ++pieces;
    };
    EXPECT_EQ(readScene(source, blob.size()).contentHash, sample().contentHash);
    EXPECT_EQ(at, blob.size());
    EXPECT_GT(pieces, 10u);
    for (const std::size_t less : {std::size_t{1}, std::size_t{8}, blob.size() / 2}) {
        at = 0;
        EXPECT_THROW(readScene(source, blob.size() - less), BlobError) << less;
        EXPECT_LE(at, blob.size() - less);
    }
    for (failAt = 0; failAt < blob.size(); failAt += 997) {
        at = 0;
        EXPECT_THROW(readScene(source, blob.size()), BlobError) << failAt;
    }
}

TEST(SceneBlob, FlippedBitsAreRejected) {
    std::vector<std::byte> blob = blobOf(sample());
    for (std::size_t i = 0; i < blob.size(); i += i < 400 ? 1 : 23) {
        const std::byte bit{static_cast<unsigned char>(1u << i % 8)};
        blob[i] ^= bit;
        EXPECT_THROW(readScene(blob), BlobError) << i;
        blob[i] ^= bit;
    }
    EXPECT_NO_THROW(readScene(blob));
}

}  // namespace
}  // namespace clerestory
