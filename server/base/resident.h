// Memory of this process.
#pragma once

namespace clerestory {

double residentBytes();  // in RAM now; 0 where the system does not tell
// What program and libraries have allocated and not given back: without what the allocator keeps.
double allocatedBytes();

// Gives memory back to the system that was freed but kept by the allocator, and the pages of the
// compiler's code, which are read again from its file when something is compiled.
void releaseUnusedMemory();

}  // namespace clerestory
