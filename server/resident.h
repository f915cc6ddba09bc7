// Memory of this process.
#pragma once

namespace clerestory {

double residentBytes();  // in RAM now; 0 where the system does not tell
// What program and libraries have allocated and not given back: without what the allocator keeps.
double allocatedBytes();

}  // namespace clerestory
