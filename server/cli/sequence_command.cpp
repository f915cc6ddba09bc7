// `clerestory sequence`: renders a sequence as of POST /v1/sequences into a folder, where it
// resumes an interrupted run, or into a film.
#include "server/api/encode_answer.h"
#include "server/base/process.h"
#include "server/cli/commands.h"
#include "server/live/film_request.h"
#include "server/live/sequence_files.h"

#include <filesystem>
#include <fstream>
#include <iostream>

namespace clerestory {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string contentOf(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

// Atomic: an interrupted run leaves no incomplete file.
void writeFrameFile(const fs::path& folder, const SequenceFile& file) {
    const fs::path unfinished = folder / (file.name + ".part");
    std::ofstream stream(unfinished, std::ios::binary);
    stream.write(file.bytes.data(), static_cast<std::streamsize>(file.bytes.size()));
    stream.close();
    if (!stream) throw std::runtime_error("cannot write \"" + unfinished.string() + "\"");
    fs::rename(unfinished, folder / file.name);
}

// Creates the folder, or verifies that it belongs to this sequence.
void openFolder(const fs::path& folder, const std::string& identity) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error) throw std::runtime_error("cannot create the folder \"" + folder.string() + "\"");
    const fs::path mark = folder / "sequence.json";
    if (!fs::exists(mark)) return writeFrameFile(folder, {"sequence.json", "", identity});
    if (contentOf(mark) != identity) {
        throw std::runtime_error("\"" + folder.string() +
                                 "\" contains frames of another sequence, scene or build; use "
                                 "another folder");
    }
}

Sequence sequenceOf(const FrameCommand& command) {
    json body = strictJson(requestText(command));
    if (body.is_object() && !command.fields.empty()) {
        json& common = body["common"];
        if (common.is_null()) common = json::object();
        if (common.is_object()) common.merge_patch(bodyFromQuery(command.fields));
    }
    return sequenceFrom(body);
}

// Of the frames in a folder: equal identities give equal frames.
std::string identityOf(const Sequence& sequence, const Scene& scene) {
    return json{{"build", buildId()},
                {"scene", scene.contentHash},
                {"channels", switchesJson(sequence.channels)},
                {"layers", switchesJson(sequence.layers)},
                {"plans", sequence.plans},
                {"common", sequence.common},
                {"frames", sequence.own}}
        .dump(1, ' ', false, json::error_handler_t::replace);
}

// Shows how many of the frames are made.
class Steps {
public:
    explicit Steps(const Sequence& sequence) : sequence_(sequence) {}
    void made(std::size_t index) {
        line_.show(static_cast<double>(index + 1 - sequence_.first) /
                   static_cast<double>(sequence_.end - sequence_.first));
    }
    void end() { line_.end(); }

private:
    const Sequence& sequence_;
    ProgressLine line_{"drawing"};
};

void drawFolder(const Sequence& sequence, const fs::path& folder, const FrameMaker& make) {
    Steps steps(sequence);
    Manifest manifest;
    std::size_t resumed = 0;
    for (std::size_t i = sequence.first; i < sequence.end; ++i) {
        const std::string last = frameStem(i) + ".json";
        if (fs::exists(folder / last)) {
            ++resumed;
            manifest.addFromFile(contentOf(folder / last));
        } else {
            const FrameFiles made = filesOf(sequence, i, make);
            for (const SequenceFile& file : made.files) writeFrameFile(folder, file);
            manifest.add(made.record);
        }
        steps.made(i);
    }
    steps.end();
    writeFrameFile(folder, manifest.file());
    std::cout << sequence.end - sequence.first << " frames in " << folder.string();
    if (resumed > 0) std::cout << ", " << resumed << " of them from an earlier run";
    std::cout << "\n";
}

// Atomic: an interrupted run leaves no film that looks whole.
void drawFilm(const Sequence& sequence, const FilmSettings& settings, const fs::path& path,
              const FrameMaker& make) {
    const fs::path unfinished = path.string() + ".part";
    std::ofstream stream(unfinished, std::ios::binary);
    const auto film = makeFilm(settings, [&](std::string_view piece) {
        stream.write(piece.data(), static_cast<std::streamsize>(piece.size()));
        return bool(stream);
    });
    Steps steps(sequence);
    bool written = true;
    for (std::size_t i = sequence.first; written && i < sequence.end; ++i) {
        written = film->add(filesOf(sequence, i, make).files.front().bytes);
        steps.made(i);
    }
    written = written && film->end();
    steps.end();
    stream.close();
    if (!written || !stream) {
        throw std::runtime_error("cannot write \"" + unfinished.string() + "\"");
    }
    fs::rename(unfinished, path);
    std::cout << sequence.end - sequence.first << " frames in " << path.string() << "\n";
}

}  // namespace

int runSequence(const CommandLine& line) {
    Sequence sequence = sequenceOf(line.frame);
    std::optional<FilmSettings> film;
    if (const auto format = filmFormatOf(line.frame.output)) {
        film = makeFilmSequence(sequence, *format);
    }
    FrameRequest lighting;  // has the map from the command line, for frames that name none
    const EnvironmentMaps maps = environmentsOf(line, lighting);
    Scene scene = sceneFor(line, maps);
    const fs::path output = line.frame.output;
    if (!film) openFolder(output, identityOf(sequence, scene));
    scene.id = "scene";
    Renderer renderer(line.config.renderer);
    for (const auto& [name, map] : maps) renderer.addEnvironment(map);
    renderer.addScene(std::move(scene));

    const FrameMaker make = [&](FrameRequest request) {
        request.scene = "scene";
        if (!request.environment.map) request.environment.map = lighting.environment.map;
        if (request.accuracy.isBudget()) {
            throw std::runtime_error("sequence does not support budgets; use a preset or settings");
        }
        requireLight(renderer, request);
        const Frame frame = renderer.render(request);
        EncodedFrame made{.type = std::string(mediaType(request.output.format)),
                          .bytes = encoded(frame, request.output)};
        addPlan(made, frame);
        return made;
    };
    if (film) {
        drawFilm(sequence, *film, output, make);
    } else {
        drawFolder(sequence, output, make);
    }
    return 0;
}

}  // namespace clerestory
