// SPDX-License-Identifier: Apache-2.0
// Point Cache 2 of 3ds Max, which Blender, Maya and Houdini read: a header, then x y z of every vertex for each frame.
#include "ndg/core/error.h"
#include "ndg/core/stream_file.h"
#include "ndg/export/mesh_sequence.h"

#include <cstdint>

namespace ndg {
namespace {

template <typename T>
void put(std::ostream& stream, const T& value)
{
    stream.write(reinterpret_cast<const char*>(&value), sizeof value);
}

void put_frames(std::ostream& stream, const MeshSequence& sequence)
{
    for (int i = 0; i < sequence.num_frames; ++i) {
        const std::vector<MeshFrame> frames = sequence.frame(i);
        if (i == 0) {
            std::int32_t num_vertices = 0;
            for (const MeshFrame& frame : frames) num_vertices += std::int32_t(frame.vertices.rows());
            stream.write("POINTCACHE2\0", 12);
            put(stream, std::int32_t(1));  // version
            put(stream, num_vertices);
            put(stream, 0.0f);  // first frame
            put(stream, 1.0f);  // frames from one sample to the next
            put(stream, std::int32_t(sequence.num_frames));
        }
        for (const MeshFrame& frame : frames) {
            const RowMatrixF vertices = frame.vertices.cast<float>();
            stream.write(reinterpret_cast<const char*>(vertices.data()),
                         std::streamsize(sizeof(float)) * vertices.size());
        }
    }
}

}  // namespace

void write_pc2(const std::string& path, const MeshSequence& sequence)
{
    write_stream(path, [&](std::ostream& stream) { put_frames(stream, sequence); });
}

}  // namespace ndg
