// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/linear_correctives.h"

#include "ndg/core/error.h"
#include "ndg/io/h5.h"

namespace ndg {

namespace {

constexpr const char* format_name = "ndg-correctives";
constexpr int format_version = 1;

std::vector<std::string> joint_names(const LinearCorrectives& correctives, const Template& body_template)
{
    std::vector<std::string> names;
    for (const int joint : correctives.joints) names.push_back(body_template.skeleton.joint_names[joint]);
    return names;
}

class CorrectiveSkinning : public Deformer {
public:
    CorrectiveSkinning(const Template& body_template, LinearCorrectives correctives)
        : correctives_(std::move(correctives)), at_rest_(body_template)
    {
    }
    Points deform(const PosedBody& posed) override
    {
        return at_rest_.vertices(posed, correctives_.offsets(posed.pose()));
    }

private:
    LinearCorrectives correctives_;
    RestOffsets at_rest_;
};

}  // namespace

Eigen::RowVectorXf LinearCorrectives::features(const Pose& pose) const
{
    Eigen::RowVectorXf features(9 * joints.size());
    for (std::size_t k = 0; k < joints.size(); ++k) {
        Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(features.data() + 9 * k) =
            (pose.parent_from_joint[joints[k]] - Eigen::Matrix3d::Identity()).cast<float>();
    }
    return features;
}

Points LinearCorrectives::offsets(const Pose& pose) const
{
    const Eigen::RowVectorXf sum = features(pose) * blend_shapes;
    return Eigen::Map<const PointsF>(sum.data(), sum.size() / 3, 3).cast<double>();
}

std::vector<int> corrective_joints(const Template& body_template)
{
    const std::vector<int> visible = body_template.visible_joints();
    std::vector<int> joints;
    for (std::size_t j = 0; j < visible.size(); ++j) {
        if (visible[j]) joints.push_back(int(j));
    }
    require_input(!joints.empty(), "no joint of the template moves any flesh");
    return joints;
}

void write_correctives(const std::string& path, const LinearCorrectives& correctives, const Template& body_template,
                       const Provenance& provenance)
{
    H5Writer writer(path, format_name, format_version, provenance);
    writer.attribute("template_sha256", correctives.template_sha256);
    write_posing(writer, correctives.posing);
    writer.attribute("ridge", correctives.ridge);
    writer.write("/correctives/joint_names", joint_names(correctives, body_template),
                 "joints whose rotations drive the blend shapes");
    writer.write("/correctives/blend_shapes",
                 {std::size_t(correctives.blend_shapes.rows()), std::size_t(correctives.blend_shapes.cols())},
                 correctives.blend_shapes.data(),
                 "entries of R - I of each joint x coordinates of each free vertex, m");
    writer.commit();
}

LinearCorrectives read_correctives(const std::string& path, const Template& body_template)
{
    const H5Reader reader(path, format_name, format_version);
    LinearCorrectives correctives;
    correctives.template_sha256 = reader.attribute("template_sha256");
    require_input(correctives.template_sha256.empty() || body_template.file_sha256.empty() ||
                      correctives.template_sha256 == body_template.file_sha256,
                  "{}: was fitted for the template with the hash {}, this one has {}", path,
                  correctives.template_sha256, body_template.file_sha256);
    correctives.posing = read_posing(reader);
    correctives.ridge = reader.attribute_double("ridge");
    correctives.joints = corrective_joints(body_template);
    require_input(reader.read_strings("/correctives/joint_names") == joint_names(correctives, body_template),
                  "{}: /correctives/joint_names are not the joints that move flesh of the template", path);
    correctives.blend_shapes =
        reader
            .read_matrix("/correctives/blend_shapes", 9 * Eigen::Index(correctives.joints.size()),
                         6 * body_template.num_wrap_vertices())
            .cast<float>();
    return correctives;
}

void register_linear_correctives(MethodTable& table)
{
    const auto path = std::make_shared<std::string>();
    table.add({"linear-correctives", "Linear correctives", "linear blend skinning and blend shapes linear in the pose",
               [path](Tool& tool) {
                   tool.input("correctives", *path, "fitted blend shapes, for the method \"linear-correctives\"",
                              false);
               },
               [path](const BodyPoser& poser) {
                   require_input(!path->empty(), "the method \"linear-correctives\" needs --correctives");
                   LinearCorrectives correctives = read_correctives(*path, poser.body_template());
                   require_input(correctives.posing.bone_wrap == poser.options().bone_wrap,
                                 "{}: was fitted to bodies posed with bone-wrap {}, these are posed with {}", *path,
                                 to_name(correctives.posing.bone_wrap), to_name(poser.options().bone_wrap));
                   return std::make_unique<CorrectiveSkinning>(poser.body_template(), std::move(correctives));
               }});
}

}  // namespace ndg
