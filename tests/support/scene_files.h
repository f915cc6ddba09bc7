// Small scene files for tests: a .glb of coloured triangles, and archives of any files.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace clerestory::test {

// `count` triangles in the plane z = 0, with vertices displaced by the seed; seeds give different
// contents.
std::string triangleGlb(unsigned seed = 0, unsigned triangles = 1);
// The same as a .gltf with an embedded buffer, or with a buffer file of that name next to it.
std::string triangleGltf(const std::string& bufferUri = "");
std::string triangleBuffer();

// The same triangle as COLLADA. perspective: the optics of a camera at (0, 0, 4) that looks at it,
// such as "<yfov>40</yfov>"; empty: no camera.
std::string triangleDae(const std::string& perspective = "");

// A .glb of a document, whose buffer 0 is that binary part.
std::string glbOf(std::string document, const std::string& binary);

struct PackedFile {
    std::string name, content;
    bool symlink = false;  // to `content`
};
enum class Packing { zip, tar, tgz };
std::string packed(Packing packing, const std::vector<PackedFile>& files);

}  // namespace clerestory::test
