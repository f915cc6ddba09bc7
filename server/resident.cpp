#include "server/resident.h"

#include <unistd.h>

#include <fstream>

namespace clerestory {

double residentBytes() {
    std::ifstream file("/proc/self/statm");
    double pages = 0.0, resident = 0.0;
    file >> pages >> resident;
    return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

}  // namespace clerestory
