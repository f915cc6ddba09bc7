#include "scene/import/base/scene_folder.h"

#include "scene/import/base/clean_text.h"
#include "scene/import/base/imported_scene.h"

#include <archive.h>
#include <archive_entry.h>

#include <algorithm>
#include <memory>
#include <string_view>
#include <vector>

namespace clerestory {
namespace {

using Reason = ImportError::Reason;
using Files = std::map<std::string, std::string>;

constexpr std::size_t kMaxName = 1024, kMaxFolders = 32;

struct Closing {
    void operator()(struct archive* a) const { archive_read_free(a); }
};
using Reading = std::unique_ptr<struct archive, Closing>;

[[noreturn]] void refuse(Reason reason, const std::string& message) {
    throw ImportError(reason, message);
}

Reading opened(const std::string& bytes) {
    Reading in(archive_read_new());
    if (!in) throw std::bad_alloc();
    archive_read_support_format_zip_seekable(
        in.get());  // needs the directory at the end: fails for truncated archives
    archive_read_support_format_tar(in.get());
    archive_read_support_filter_gzip(in.get());
    if (archive_read_open_memory(in.get(), bytes.data(), bytes.size()) != ARCHIVE_OK) {
        refuse(Reason::malformed, "the archive is neither .zip nor .tar");
    }
    return in;
}

// The parts of an entry's path. Throws unless it is a relative path within the archive.
std::vector<std::string_view> partsOf(std::string_view name) {
    const auto bad = [&](const char* what) {
        refuse(Reason::malformed, "the archive has a file whose name " + std::string(what) + ": '" +
                                      cleanText(std::string(name.substr(0, 100))) + "'");
    };
    if (name.empty() || name.size() > kMaxName) bad("is empty or too long");
    if (name.front() == '/') bad("is not relative");
    if (name.find('\\') != std::string_view::npos || name.find(':') != std::string_view::npos) {
        bad("has a backslash or a colon");
    }
    std::vector<std::string_view> parts;
    for (std::string_view rest = name; !rest.empty();) {
        const std::size_t end = std::min(rest.find('/'), rest.size());
        const std::string_view part = rest.substr(0, end);
        rest.remove_prefix(std::min(end + 1, rest.size()));
        if (part == "..") bad("leads out of it");
        if (!part.empty() && part != ".") parts.push_back(part);
    }
    if (parts.size() > kMaxFolders) bad("is nested too deep");
    return parts;
}

std::string joined(const std::vector<std::string_view>& parts) {
    std::string name;
    for (const std::string_view part : parts) name += (name.empty() ? "" : "/") + std::string(part);
    return name;
}

// Metadata that macOS adds to archives.
bool isSystemFile(const std::vector<std::string_view>& parts) {
    return parts.front() == "__MACOSX" || parts.back().starts_with("._") ||
           parts.back() == ".DS_Store";
}

std::string contentOf(struct archive* in, std::uint64_t maxBytes, const std::string& name) {
    std::string content;
    char piece[65536];
    for (;;) {
        const la_ssize_t got = archive_read_data(in, piece, sizeof piece);
        if (got == 0) return content;
        if (got < 0) refuse(Reason::malformed, "the archive is damaged or encrypted");
        if (content.size() + static_cast<std::size_t>(got) > maxBytes) {
            refuse(Reason::limit,
                   "'" + cleanText(name) + "' exceeds the size limit for scene files");
        }
        content.append(piece, static_cast<std::size_t>(got));
    }
}

Files unpacked(const std::string& bytes, const ImportLimits& limits) {
    const Reading in = opened(bytes);
    Files files;
    std::uint64_t left = 4 * limits.fileBytes, entries = 0;  // as in SceneFolder
    for (;;) {
        struct archive_entry* entry = nullptr;
        const int status = archive_read_next_header(in.get(), &entry);
        if (status == ARCHIVE_EOF) return files;
        if (status != ARCHIVE_OK && status != ARCHIVE_WARN) {
            refuse(Reason::malformed, "the archive is damaged");
        }
        // Folders count, too: they take the same time.
        if (++entries > limits.maxFiles) refuse(Reason::limit, "the archive has too many files");
        const char* utf8 = archive_entry_pathname_utf8(entry);
        const char* name = utf8 ? utf8 : archive_entry_pathname(entry);
        const auto parts = partsOf(name ? name : "");
        const bool link = archive_entry_hardlink(entry) || archive_entry_symlink(entry);
        const auto type = archive_entry_filetype(entry);
        if (link || (type != AE_IFREG && type != AE_IFDIR)) {
            refuse(Reason::malformed, "the archive has a link or a device");
        }
        if (type == AE_IFDIR || parts.empty() || isSystemFile(parts)) continue;
        const std::string path = joined(parts);
        std::string content = contentOf(in.get(), std::min(limits.fileBytes, left), path);
        left -= content.size();
        if (!files.emplace(path, std::move(content)).second) {
            refuse(Reason::malformed, "the archive has '" + cleanText(path) + "' twice");
        }
    }
}

// 0: not a scene. Of several scenes in one folder those with the lowest rank are considered.
int rankOf(const std::string& path) {
    std::string extension = path.substr(std::min(path.rfind('.'), path.size() - 1));
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (extension == ".glb" || extension == ".gltf") return 1;
    if (isArchive(extension.substr(1))) return 0;
    const auto& known = importableExtensions();
    return std::find(known.begin(), known.end(), extension.substr(1)) == known.end() ? 0 : 2;
}

std::string scenePath(const Files& files) {
    std::vector<std::string> best;
    std::pair<std::ptrdiff_t, int> leastSoFar{};
    for (const auto& [path, content] : files) {
        const int rank = rankOf(path);
        if (rank == 0) continue;
        const std::pair key{std::count(path.begin(), path.end(), '/'), rank};
        if (best.empty() || key < leastSoFar) best.clear();
        if (best.empty()) leastSoFar = key;
        if (key == leastSoFar) best.push_back(path);
    }
    if (best.empty())
        refuse(Reason::unsupported,
               "the archive has no scene file (" + extensionsText(FormatUse::scene) + ")");
    if (best.size() > 1) {
        refuse(Reason::unsupported, "the archive has more than one scene: '" + cleanText(best[0]) +
                                        "', '" + cleanText(best[1]) + "'");
    }
    return best.front();
}

}  // namespace

bool isArchive(const std::string& extension) {
    return extension == "zip" || extension == "tar" || extension == "tgz";
}

UnpackedScene unpackedScene(const std::string& archive, const ImportLimits& limits) {
    Files all = unpacked(archive, limits);
    const std::string path = scenePath(all);
    const std::size_t folder = path.rfind('/') + 1;  // npos + 1 is 0
    UnpackedScene scene{.name = path.substr(folder)};
    const std::string_view prefix = std::string_view(path).substr(0, folder);
    for (auto& [name, content] : all) {
        if (name.starts_with(prefix)) scene.files.emplace(name.substr(folder), std::move(content));
    }
    return scene;
}

}  // namespace clerestory
