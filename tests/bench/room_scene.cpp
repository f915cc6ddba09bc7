#include "room_scene.h"

#include "room.h"
#include "scenes.h"

#include <unistd.h>

#include <filesystem>

namespace clerestory::bench {

Scene roomOrScene(const std::string& argument) {
    if (argument != "room") return loadScene(argument);
    const std::filesystem::path folder =
        std::filesystem::temp_directory_path() / ("clerestory-room-" + std::to_string(getpid()));
    std::filesystem::create_directory(folder);
    Scene scene = loadScene(writeRoom(folder).string());
    std::filesystem::remove_all(folder);
    return scene;
}

}  // namespace clerestory::bench
