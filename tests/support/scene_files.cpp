#include "tests/support/scene_files.h"

#include <archive.h>
#include <archive_entry.h>

#include <cstdint>
#include <cstring>
#include <stdexcept>

namespace clerestory::test {
namespace {

std::string vertices(unsigned seed, unsigned triangles) {
    std::string bytes;
    for (unsigned t = 0; t < triangles; ++t) {
        const float x = 0.01f * static_cast<float>(t % 100),
                    y = 0.01f * static_cast<float>(t / 100);
        const float size = 1.0f + 0.001f * static_cast<float>(seed);
        const float corners[] = {x, y, 0, x + size, y, 0, x, y + size, 0};
        bytes.append(reinterpret_cast<const char*>(corners), sizeof corners);
    }
    return bytes;
}

std::string document(const std::string& buffer, std::size_t bytes, unsigned triangles) {
    const std::string count = std::to_string(3 * triangles);
    return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
           R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"buffers":[{)" +
           buffer + R"("byteLength":)" + std::to_string(bytes) +
           R"(}],"bufferViews":[{"buffer":0,"byteLength":)" + std::to_string(bytes) +
           R"(}],"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":)" +
           count + R"(,"min":[0,0,0],"max":[100,100,0]}]})";
}

void append32(std::string& text, std::size_t value) {
    const auto number = static_cast<std::uint32_t>(value);
    text.append(reinterpret_cast<const char*>(&number), sizeof number);
}

std::string base64(const std::string& bytes) {
    constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i + 2 < bytes.size(); i += 3) {  // triangles: a multiple of 36 bytes
        const auto at = [&](std::size_t k) { return static_cast<unsigned char>(bytes[i + k]); };
        const unsigned group = at(0) << 16 | at(1) << 8 | at(2);
        for (int shift = 18; shift >= 0; shift -= 6) text += kDigits[group >> shift & 63];
    }
    return text;
}

la_ssize_t append(struct archive*, void* text, const void* bytes, std::size_t size) {
    static_cast<std::string*>(text)->append(static_cast<const char*>(bytes), size);
    return static_cast<la_ssize_t>(size);
}

}  // namespace

std::string triangleDae(const std::string& perspective) {
    std::string cameras, node;
    if (!perspective.empty()) {
        cameras = "<library_cameras><camera id=\"c\"><optics><technique_common><perspective>" +
                  perspective +
                  "</perspective></technique_common></optics></camera></library_cameras>";
        node = R"(<node id="eye"><translate>0 0 4</translate><instance_camera url="#c"/></node>)";
    }
    return R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema"
version="1.4.1"><asset><unit meter="1"/><up_axis>Y_UP</up_axis></asset>)" +
           cameras + R"(<library_geometries>
<geometry id="g"><mesh><source id="p"><float_array id="a" count="9">0 0 0 1 0 0 0 1 0</float_array>
<technique_common><accessor source="#a" count="3" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices><triangles count="1">
<input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh></geometry>
</library_geometries><library_visual_scenes><visual_scene id="s"><node id="n">
<instance_geometry url="#g"/></node>)" +
           node + R"(</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
}

std::string glbOf(std::string json, const std::string& binary) {
    json.resize((json.size() + 3) / 4 * 4, ' ');
    std::string glb = "glTF";
    append32(glb, 2);
    append32(glb, 12 + 8 + json.size() + 8 + binary.size());
    append32(glb, json.size());
    glb += "JSON" + json;
    append32(glb, binary.size());
    glb += std::string("BIN\0", 4) + binary;
    return glb;
}

std::string triangleGlb(unsigned seed, unsigned triangles) {
    const std::string binary = vertices(seed, triangles);
    return glbOf(document("", binary.size(), triangles), binary);
}

std::string triangleBuffer() {
    return vertices(0, 1);
}

std::string triangleGltf(const std::string& bufferUri) {
    const std::string uri = bufferUri.empty()
                                ? "data:application/octet-stream;base64," + base64(triangleBuffer())
                                : bufferUri;
    return document("\"uri\":\"" + uri + "\",", triangleBuffer().size(), 1);
}

std::string packed(Packing packing, const std::vector<PackedFile>& files) {
    std::string text;
    struct archive* out = archive_write_new();
    if (packing == Packing::zip) {
        archive_write_set_format_zip(out);
    } else {
        archive_write_set_format_pax_restricted(out);
    }
    if (packing == Packing::tgz) archive_write_add_filter_gzip(out);
    archive_write_set_bytes_per_block(out, 0);
    archive_write_open(out, &text, nullptr, append, nullptr);
    for (const PackedFile& file : files) {
        struct archive_entry* entry = archive_entry_new();
        archive_entry_set_pathname(entry, file.name.c_str());
        archive_entry_set_perm(entry, 0644);
        archive_entry_set_mtime(entry, 0, 0);
        archive_entry_set_filetype(entry, file.symlink ? AE_IFLNK : AE_IFREG);
        if (file.symlink) {
            archive_entry_set_symlink(entry, file.content.c_str());
        } else {
            archive_entry_set_size(entry, static_cast<la_int64_t>(file.content.size()));
        }
        archive_write_header(out, entry);
        if (!file.symlink) archive_write_data(out, file.content.data(), file.content.size());
        archive_entry_free(entry);
    }
    const bool whole = archive_write_close(out) == ARCHIVE_OK;
    archive_write_free(out);
    if (!whole) throw std::runtime_error("the archive could not be made");
    return text;
}

}  // namespace clerestory::test
