#include "tests/http/sequences_support.h"

#include <archive.h>
#include <archive_entry.h>

namespace clerestory::test {

using nlohmann::json;

Files filesOfTar(const std::string& tar) {
    Files files;
    struct archive* in = archive_read_new();
    archive_read_support_format_tar(in);
    EXPECT_EQ(archive_read_open_memory(in, tar.data(), tar.size()), ARCHIVE_OK);
    archive_entry* entry = nullptr;
    while (archive_read_next_header(in, &entry) == ARCHIVE_OK) {
        std::string content(static_cast<std::size_t>(archive_entry_size(entry)), '\0');
        EXPECT_EQ(archive_read_data(in, content.data(), content.size()),
                  static_cast<la_ssize_t>(content.size()));
        files.emplace_back(archive_entry_pathname(entry), std::move(content));
    }
    archive_read_free(in);
    return files;
}

std::string fileOf(const Files& files, const std::string& name) {
    for (const auto& [n, content] : files) {
        if (n == name) return content;
    }
    ADD_FAILURE() << "no file " << name;
    return {};
}

json orbit(int frames, const json& more) {
    json list = json::array();
    for (int i = 0; i < frames; ++i) {
        list.push_back({{"camera", {{"position", {0.4 * i, 1.0, 2.0}}, {"target", {0, 1, 0}}}}});
    }
    json body = {{"common",
                  {{"scene", "six-walls"},
                   {"width", 64},
                   {"height", 48},
                   {"effects", {{"indirectLight", false}}}}},
                 {"frames", list}};
    body.merge_patch(more);
    return body;
}

}  // namespace clerestory::test
