// The program: reads the command line and runs one command. Failures become lines on stderr.
#include "renderer.h"
#include "scene/import/in_process.h"
#include "server/base/log.h"
#include "server/base/problem.h"
#include "server/cli/commands.h"
#include "server/scenes/shader_cache.h"
#include "server/worker/worker.h"

#include <cstring>
#include <filesystem>
#include <iostream>

namespace {

using namespace clerestory;

int run(const CommandLine& line) {
    switch (line.command) {
        case Command::serve:
            return runServe(line);
        case Command::render:
            return runRender(line);
        case Command::plan:
            return runPlan(line);
        case Command::reference:
            return runReference(line);
        case Command::compare:
            return runCompare(line);
        case Command::compile:
            return runCompile(line);
        case Command::sequence:
            return runSequence(line);
        case Command::sign:
            return runSign(line);
        case Command::scenes:
            return runScenes();
        case Command::devices:
            return runDevices();
    }
    return 2;
}

int fail(const std::string& message) {
    std::cerr << "clerestory: " << message << "\n";
    return 2;
}

// One line for each wrong field.
int fail(const std::vector<FieldError>& errors) {
    for (const FieldError& e : errors) {
        fail((e.pointer.empty() ? "the request" : e.pointer) + " " + e.detail +
             (e.allowed.empty() ? "" : "; allowed: " + e.allowed));
    }
    return 2;
}

}  // namespace

int main(int argc, char** argv) {
    // Two commands that the program starts itself and the help does not list: by importScene(),
    if (argc > 1 && std::strcmp(argv[1], "import-child") == 0) return importChildMain(argc, argv);
    // and by a server for each renderer process, with the arguments of `serve`.
    const bool isWorker = argc > 1 && std::strcmp(argv[1], kWorkerCommand) == 0;
    char serve[] = "serve";
    if (isWorker) argv[1] = serve;
    CommandLine line;
    if (const auto done = parseCommandLine(argc, argv, line)) return *done;
    logToStandardError();
    useShaderCache(line.config.shaderCache);
    if (isWorker) return runWorker(workerOptions(line.config), localBackendOptions(line.config));
    try {
        const int status = run(line);
        endDriver();
        return status;
    } catch (const RequestError& error) {
        if (!error.problem().errors.empty()) return fail(error.problem().errors);
        return fail(error.problem().detail);
    } catch (const InvalidRequest& error) {
        return fail(error.errors());
    } catch (const std::filesystem::filesystem_error& error) {
        return fail(error.path1().string() + ": " + error.code().message());
    } catch (const std::bad_alloc&) {
        return fail("out of memory");
    } catch (const std::exception& error) {
        return fail(error.what());
    }
}
