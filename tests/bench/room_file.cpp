// `bench_room FOLDER [EDGE HEIGHT]`: writes the room of room.h into a folder that exists, for
// programs that read files. EDGE and HEIGHT are in metres.
#include "program.h"
#include "room.h"

#include <cstdio>
#include <stdexcept>
#include <string>

namespace clerestory::bench {
namespace {

int writeFile(int argc, char** argv) {
    if (argc != 2 && argc != 4) {
        std::fprintf(stderr, "usage: bench_room FOLDER [EDGE HEIGHT]\n");
        return 2;
    }
    RoomSize size;
    if (argc == 4) size = {.edge = std::stof(argv[2]), .height = std::stof(argv[3])};
    // Written so that NaN is refused as well.
    if (!(size.edge >= 6.0f && size.edge <= 100.0f && size.height >= 4.0f && size.height <= 50.0f))
        throw std::runtime_error("EDGE is 6 to 100 metres and HEIGHT is 4 to 50 metres");
    std::printf("%s\n", writeRoom(argv[1], size).c_str());
    return 0;
}

}  // namespace
}  // namespace clerestory::bench

int main(int argc, char** argv) {
    return clerestory::bench::runProgram("bench_room", clerestory::bench::writeFile, argc, argv);
}
