// SPDX-License-Identifier: Apache-2.0
// XDMF, which ParaView and VisIt read: a small XML file that says where in HDF5 files the numbers are. What stands in
// files already (cells in a template, vertices in samples) is referred to; the rest is written beside it as PATH.h5
// (format "ndg-fields", docs/formats.md). A grid a kind of cells, a collection of them a frame, a series over time.
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/markup.h"
#include "ndg/export/mesh_sequence.h"
#include "ndg/io/h5.h"

#include <filesystem>

namespace ndg {
namespace {

std::string extents(const std::vector<std::size_t>& shape)
{
    return fmt::format("{}", fmt::join(shape, " "));
}

/// One array as an item of XML; paths relative to the folder of the file at `path`.
std::string data_item(const std::string& path, const StoredArray& array, const char* number_type)
{
    namespace fs = std::filesystem;
    const std::string file =
        fs::proximate(fs::absolute(array.file), fs::absolute(path).parent_path()).lexically_normal().string();
    const std::string whole =
        fmt::format("<DataItem Format=\"HDF\" NumberType=\"{}\" Precision=\"4\" Dimensions=\"{}\">{}:{}</DataItem>",
                    number_type, extents(array.shape), escaped_markup(file), array.dataset);
    if (array.slice < 0) return whole;
    std::vector<std::size_t> begin(array.shape.size(), 0), step(array.shape.size(), 1), count = array.shape;
    begin[0] = std::size_t(array.slice);
    count[0] = 1;
    const std::vector<std::size_t> shape(array.shape.begin() + 1, array.shape.end());
    // VTK's reader takes what a geometry's item begins with as the name by which it keeps grids: a comment, its own in
    // every frame.
    return fmt::format(
        "<DataItem ItemType=\"HyperSlab\" Dimensions=\"{}\"><!--slice {}--><DataItem Format=\"XML\" Dimensions=\"3 "
        "{}\">{} {} {}</DataItem>{}</DataItem>",
        extents(shape), array.slice, array.shape.size(), extents(begin), extents(step), extents(count), whole);
}

/// The HDF5 file beside, filled frame by frame.
class FieldFile {
public:
    FieldFile(const std::string& path, const MeshSequence& sequence)
        : path_(path),
          num_frames_(std::size_t(sequence.num_frames)),
          writer_(path, "ndg-fields", 1, sequence.volume->provenance)
    {
    }

    /// The same in all frames.
    StoredArray add(const std::string& name, const Eigen::VectorXf& values)
    {
        writer_.write(name, std::vector<double>(values.data(), values.data() + values.size()),
                      "field, one value a cell", Storage::float32);
        return {path_, name, {std::size_t(values.size())}};
    }
    /// One frame's; the first makes the dataset.
    StoredArray add(const std::string& name, int frame_idx, const Eigen::Ref<const RowMatrixF>& values,
                    const std::string& description)
    {
        std::vector<std::size_t> shape = {num_frames_, std::size_t(values.rows())};
        if (values.cols() > 1) shape.push_back(std::size_t(values.cols()));
        if (frame_idx == 0) writer_.create(name, shape, description);
        writer_.write_slice(name, std::size_t(frame_idx), values.data());
        return {path_, name, shape, frame_idx};
    }
    void commit() { writer_.commit(); }

private:
    std::string path_;
    std::size_t num_frames_;
    H5Writer writer_;
};

/// Writes a sequence's own numbers and tells of all of them.
class XdmfWriter {
public:
    XdmfWriter(const std::string& path, const MeshSequence& sequence)
        : path_(path), volume_(*sequence.volume), file_(path + ".h5", sequence)
    {
        for (const VolumeGrid& grid : volume_.grids) {
            std::string& fields = constant_fields_.emplace_back();
            for (const auto& [name, values] : grid.cell_fields) {
                require(std::size_t(values.size()) == grid.cells.shape.at(0), "{}: {} of {} is not one value a cell",
                        path, name, grid.name);
                fields += attribute(name, "Cell", file_.add(fmt::format("/{}/constant/{}", grid.name, name), values));
            }
        }
    }

    std::string frame_text(int frame_idx, double time)
    {
        const std::vector<VolumeFrame> frames = volume_.frame(frame_idx);
        require(frames.size() == volume_.grids.size(), "{}: frame {} has {} grids instead of {}", path_, frame_idx,
                frames.size(), volume_.grids.size());
        std::string text = fmt::format(
            "   <Grid Name=\"frame_{}\" GridType=\"Collection\" CollectionType=\"Spatial\">\n    <Time "
            "Value=\"{}\"/>\n",
            frame_idx, time);
        for (std::size_t k = 0; k < frames.size(); ++k) text += grid_text(k, frame_idx, frames[k]);
        return text + "   </Grid>\n";
    }
    void commit() { file_.commit(); }

private:
    std::string attribute(const std::string& name, const char* centre, const StoredArray& values) const
    {
        return fmt::format("     <Attribute Name=\"{}\" AttributeType=\"Scalar\" Center=\"{}\">{}</Attribute>\n",
                           escaped_markup(name), centre, data_item(path_, values, "Float"));
    }

    std::string grid_text(std::size_t k, int frame_idx, const VolumeFrame& frame)
    {
        const VolumeGrid& grid = volume_.grids[k];
        const std::size_t num_cells = grid.cells.shape.at(0);
        const StoredArray vertices = frame.stored_vertices ? *frame.stored_vertices
                                                           : file_.add(fmt::format("/{}/vertices", grid.name),
                                                                       frame_idx, frame.vertices.cast<float>(), "m");
        std::string text = fmt::format(
            "    <Grid Name=\"{}\" GridType=\"Uniform\">\n     <Topology TopologyType=\"{}\" NumberOfElements=\"{}\">{}"
            "</Topology>\n     <Geometry GeometryType=\"XYZ\">{}</Geometry>\n",
            grid.name, grid.kind == CellKind::wedge ? "Wedge" : "Tetrahedron", num_cells,
            data_item(path_, grid.cells, "Int"), data_item(path_, vertices, "Float"));
        const auto add_fields = [&](const Fields& fields, const char* centre, const char* group, std::size_t count) {
            for (const auto& [name, values] : fields) {
                require(std::size_t(values.size()) == count, "{}: {} of {} has {} values for {}", path_, name,
                        grid.name, values.size(), count);
                const std::string dataset = fmt::format("/{}/{}/{}", grid.name, group, name);
                text += attribute(name, centre, file_.add(dataset, frame_idx, values, "field of each frame"));
            }
        };
        add_fields(frame.point_fields, "Node", "points", std::size_t(frame.vertices.rows()));
        add_fields(frame.cell_fields, "Cell", "cells", num_cells);
        return text + constant_fields_[k] + "    </Grid>\n";
    }

    std::string path_;
    const VolumeSequence& volume_;
    FieldFile file_;
    std::vector<std::string> constant_fields_;  ///< of each grid
};

}  // namespace

void write_xdmf(const std::string& path, const MeshSequence& sequence)
{
    XdmfWriter writer(path, sequence);
    std::string text =
        "<?xml version=\"1.0\"?>\n<!DOCTYPE Xdmf SYSTEM \"Xdmf.dtd\" []>\n<Xdmf Version=\"2.0\">\n <Domain>\n";
    text += fmt::format("  <Information Name=\"licences\" Value=\"{}\"/>\n", escaped_markup(sequence.credits));
    text += "  <Grid Name=\"body\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
    for (int f = 0; f < sequence.num_frames; ++f) text += writer.frame_text(f, f / sequence.frame_rate);
    text += "  </Grid>\n </Domain>\n</Xdmf>\n";
    writer.commit();
    write_file(path, text);
}

}  // namespace ndg
