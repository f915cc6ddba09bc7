// The documents of the repository: generated parts are up to date, links lead to files, and the
// requests that they show work.
//
// CLERESTORY_UPDATE_DOCUMENTS=1 writes the generated parts.
#include "tests/support/test_server.h"

#include "scene/import/base/types.h"
#include "server/api/openapi.h"
#include "server/base/problem.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

namespace clerestory::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const fs::path kRoot = CLERESTORY_SOURCE_DIR;

std::string contentOf(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    EXPECT_TRUE(file) << path;
    std::ostringstream content;
    content << file.rdbuf();
    return content.str();
}

// Each is one row of the table of problems.
TEST(DocumentFiles, EveryProblemIsListed) {
    const std::string reference = contentOf(kRoot / "docs/api.md");
    for (std::size_t code = 0; code < kProblemCodes; ++code) {
        const std::string cell =
            "| `" + std::string(nameOf(static_cast<ProblemCode>(code))) + "` |";
        EXPECT_THAT(reference, testing::HasSubstr(cell));
    }
}

void expectContent(const fs::path& path, const std::string& expected) {
    if (std::getenv("CLERESTORY_UPDATE_DOCUMENTS")) std::ofstream(path) << expected;
    EXPECT_TRUE(contentOf(path) == expected)
        << path << " is out of date: run CLERESTORY_UPDATE_DOCUMENTS=1 scripts/test -R http_api";
}

std::vector<fs::path> documents() {
    std::vector<fs::path> list;
    for (const char* folder : {"", "docs", "docs/architecture"}) {
        for (const auto& entry : fs::directory_iterator(kRoot / folder)) {
            if (entry.path().extension() == ".md") list.push_back(entry.path());
        }
    }
    return list;
}

// Anchors as GitHub derives them from headings.
std::string anchorOf(std::string heading) {
    std::string anchor;
    for (const char c : heading) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == ' ') anchor += '-';
        if (std::isalnum(byte) || c == '-' || c == '_' || byte >= 128) {
            anchor += static_cast<char>(std::tolower(byte));
        }
    }
    return anchor;
}

bool hasHeading(const std::string& document, const std::string& anchor) {
    std::istringstream lines(document);
    for (std::string line; std::getline(lines, line);) {
        const std::size_t text = line.find_first_not_of('#');
        if (text == 0 || text == std::string::npos || line[text] != ' ') continue;
        if (anchorOf(line.substr(text + 1)) == anchor) return true;
    }
    return false;
}

TEST(DocumentFiles, TheApiReferenceIsThatOfTheFieldTables) {
    expectContent(kRoot / "docs/api.md", apiDocument());
}

// The text between the markers of a generated part of a document is replaced.
std::string withPart(const std::string& document, const std::string& part,
                     const std::string& content) {
    const std::string begin = "<!-- generated from the importer's list: " + part + " -->\n";
    const std::size_t from = document.find(begin), to = document.find("<!-- end of " + part);
    if (from == std::string::npos || to == std::string::npos) {
        ADD_FAILURE() << "no position for " << part;
        return document;
    }
    return document.substr(0, from) + begin + content + document.substr(to);
}

std::string formatTable() {
    std::ostringstream out;
    out << "| Format | Extensions | Use | Remarks |\n|---|---|---|---|\n";
    for (const FileFormat& format : fileFormats()) {
        out << "| " << format.name << " |";
        std::istringstream extensions{std::string(format.extensions)};
        for (std::string each; extensions >> each;) out << " `" << each << "`";
        out << " | " << nameOf(format.use) << " | " << format.note << " |\n";
    }
    return out.str();
}

std::string extensionTable() {
    std::ostringstream out;
    out << "| Extension | Support | Remarks |\n|---|---|---|\n";
    for (const GltfExtension& extension : gltfExtensions()) {
        out << "| `" << extension.name << "` | " << nameOf(extension.support) << " | "
            << extension.note << " |\n";
    }
    return out.str();
}

TEST(DocumentFiles, TablesOfFormatsAreThoseOfTheImporter) {
    const fs::path path = kRoot / "docs/scenes.md";
    std::string expected = withPart(contentOf(path), "formats", formatTable());
    expected = withPart(expected, "extensions", extensionTable());
    expectContent(path, expected);
}

TEST(DocumentFiles, LinksLeadToFilesAndHeadings) {
    static const std::regex link(R"(\]\(([^)\s]+)\))");
    std::size_t count = 0;
    for (const fs::path& path : documents()) {
        const std::string text = contentOf(path);
        for (std::sregex_iterator it(text.begin(), text.end(), link), end; it != end; ++it) {
            const std::string target = (*it)[1];
            if (target.find("://") != std::string::npos) continue;
            const std::size_t hash = std::min(target.find('#'), target.size());
            const fs::path file = hash == 0 ? path : path.parent_path() / target.substr(0, hash);
            ++count;
            ASSERT_TRUE(fs::exists(file)) << path << " links to " << target;
            if (hash == target.size()) continue;
            EXPECT_TRUE(hasHeading(contentOf(file), target.substr(hash + 1)))
                << path << " links to " << target;
        }
    }
    EXPECT_GT(count, 50u);
}

TEST(DocumentFiles, TheReadmeHasAtMost120Lines) {
    const std::string readme = contentOf(kRoot / "README.md");
    EXPECT_LE(std::count(readme.begin(), readme.end(), '\n'), 120);
}

// Small and quick, without waiting for light between surfaces, otherwise as written.
json reduced(json body) {
    for (const char* name : {"width", "height"}) {
        if (body.contains(name)) body[name] = 32;
        if (body.contains("common")) body["common"][name] = 32;
    }
    if (body.contains("samples")) body["samples"] = 2;
    if (body.contains("settings")) body["frames"] = 1;
    if (body.contains("turntable")) body["turntable"]["seconds"] = 0.2;
    json& frame = body.contains("common") ? body["common"] : body;
    frame["effects"]["indirectLight"] = false;
    return body;
}

// The argument of curl's -d.
TEST(DocumentFiles, PostedRequestsAreAccepted) {
    static const std::regex command(
        R"(curl [^\n]*localhost:8080(/v1/[a-z]+)[^']*-H 'Content-Type: application/json'[^']*-d '([^']*)')");
    TestServer server;
    auto client = server.client();
    std::size_t count = 0;
    for (const fs::path& path : documents()) {
        const std::string text = contentOf(path);
        for (std::sregex_iterator it(text.begin(), text.end(), command), end; it != end; ++it) {
            const json body = json::parse((*it)[2].str());
            const auto result = postUntilReady(client, (*it)[1], reduced(body).dump());
            ASSERT_TRUE(result) << path;
            EXPECT_EQ(result->status / 100, 2) << path << ": " << result->body;
            ++count;
        }
    }
    EXPECT_GE(count, 3u);
}

TEST(DocumentFiles, FencedFrameRequestsAreAccepted) {
    static const std::regex block("```json\n(\\{ \"scene\"[^`]*)```");
    static const std::set<std::string> builtin = {"chapel", "six-walls", "orbiting-cubes",
                                                  "teapots", "meadow"};
    auto client = sharedServer().client();
    std::size_t count = 0;
    for (const fs::path& path : documents()) {
        const std::string text = contentOf(path);
        for (std::sregex_iterator it(text.begin(), text.end(), block), end; it != end; ++it) {
            json body = json::parse((*it)[1].str());
            if (body["scene"].is_string() && !builtin.contains(body["scene"])) {
                body["scene"] = "six-walls";
            }
            const auto result = postUntilReady(client, "/v1/plans", body.dump());
            ASSERT_TRUE(result) << path;
            EXPECT_EQ(result->status, 200) << path << ": " << result->body;
            ++count;
        }
    }
    EXPECT_GE(count, 1u);
}

}  // namespace
}  // namespace clerestory::test
