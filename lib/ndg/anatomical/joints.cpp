// SPDX-License-Identifier: Apache-2.0
#include "ndg/anatomical/joints.h"

#include "ndg/body_source/bone_parts.h"

#include <array>

namespace ndg {
namespace {

void add_arm(const PartFinder& bones, const std::string& side, double lateral, BonePoints& points)
{
    const auto bone = [&](const std::string& name) -> const Points& { return bones.part(side + " " + name).vertices; };
    const auto set = [&](const std::string& name, const Eigen::Vector3d& point) { points[side + "_" + name] = point; };
    const Eigen::Vector3d out(lateral, 0, 0), up(0, 1, 0);
    set("clavicle", end_centre(bone("clavicle"), -out, 0.008));
    set("acromion_end", end_centre(bone("clavicle"), out, 0.008));
    // Radius of an adult's humeral head: 23 mm (Iannotti et al. 1992: 24 +- 2).
    set("upper_arm", head_sphere(bone("humerus"), up - 0.8 * out, 0.023).centre);
    const Points& humerus = bone("humerus");
    Points distal = near(humerus, end_centre(humerus, -up, 0.03), 0.045);
    set("lateral_epicondyle", farthest(distal, out));
    set("medial_epicondyle", farthest(distal, -out));
    set("forearm", 0.5 * (points[side + "_lateral_epicondyle"] + points[side + "_medial_epicondyle"]));
    set("radial_head", end_centre(bone("radius"), up, 0.008));
    set("ulnar_head", end_centre(bone("ulna"), -up, 0.014));
    set("hand", 0.5 * (middle(bone("scaphoid")) + middle(bone("lunate"))));

    for (const auto& [finger, ordinal, words] : finger_names) {
        const auto phalanx = [&](const std::string& which) -> const Points& {
            return bones.part(which + " phalanx of " + side + " " + words).vertices;
        };
        const Points& metacarpal = bone(std::string(ordinal) + " metacarpal bone");
        const bool is_thumb = std::string(finger) == "thumb";
        const Eigen::Vector3d metacarpal_axis = middle(phalanx("proximal")) - middle(metacarpal);
        const Eigen::Vector3d proximal_axis = middle(phalanx("distal")) - middle(phalanx("proximal"));
        const std::string name = std::string(finger);
        if (is_thumb) {
            set("thumb_1", end_centre(metacarpal, -metacarpal_axis, 0.008));
            set("thumb_2", end_centre(metacarpal, metacarpal_axis, 0.012));
            set("thumb_3", end_centre(phalanx("proximal"), proximal_axis, 0.008));
        } else {
            const Eigen::Vector3d distal_axis = middle(phalanx("distal")) - middle(phalanx("middle"));
            set(name + "_base", end_centre(metacarpal, -metacarpal_axis, 0.008));
            set(name + "_1", end_centre(metacarpal, metacarpal_axis, 0.012));
            set(name + "_2", end_centre(phalanx("proximal"), proximal_axis, 0.008));
            set(name + "_3", end_centre(phalanx("middle"), distal_axis, 0.006));
        }
        set(name + "_tip", farthest(phalanx("distal"), middle(phalanx("distal")) - points[side + "_" + name + "_3"]));
    }
}

void add_leg(const PartFinder& bones, const std::string& side, double lateral, BonePoints& points)
{
    const auto bone = [&](const std::string& name) -> const Points& { return bones.part(side + " " + name).vertices; };
    const auto set = [&](const std::string& name, const Eigen::Vector3d& point) { points[side + "_" + name] = point; };
    const Eigen::Vector3d out(lateral, 0, 0), up(0, 1, 0), front(0, 0, 1);
    // Radius of an adult's femoral head: 24 mm (Noble et al. 1988: diameter 46 +- 5 mm).
    set("thigh", head_sphere(bone("femur"), up - 1.2 * out, 0.023).centre);
    const Points distal = near(bone("femur"), end_centre(bone("femur"), -up, 0.03), 0.06);
    set("shin", 0.5 * (farthest(distal, out) + farthest(distal, -out)));
    set("foot", 0.5 * (end_centre(bone("fibula"), -up, 0.01) +
                       end_centre(near(bone("tibia"), end_centre(bone("tibia"), -up, 0.02), 0.04), -up - out, 0.006)));
    const std::array<std::array<const char*, 2>, 5> toes = {
        {{"first", "big"}, {"second", "second"}, {"third", "third"}, {"fourth", "fourth"}, {"fifth", "little"}}};
    Eigen::Vector3d heads = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < toes.size(); ++k) {
        const Eigen::Vector3d head =
            end_centre(bone(std::string(toes[k][0]) + " metatarsal bone"), front - 0.3 * up, 0.012);
        const Points& tip = bones.part("distal phalanx of " + side + " " + toes[k][1] + " toe").vertices;
        set("toe_" + std::to_string(k + 1), head);
        set("toe_" + std::to_string(k + 1) + "_tip", farthest(tip, middle(tip) - head));
        heads += 0.2 * head;
    }
    set("toes", heads);
    set("heel", farthest(bone("calcaneus"), -front));
}

}  // namespace

BonePoints bone_points(const std::vector<AnatomyMesh>& parts)
{
    const PartFinder bones(parts);
    BonePoints points;
    const std::array<std::array<const char*, 2>, 7> disks = {{{"spine_1", "fourth lumbar vertebra"},
                                                              {"spine_2", "second lumbar vertebra"},
                                                              {"spine_3", "twelfth thoracic vertebra"},
                                                              {"spine_4", "ninth thoracic vertebra"},
                                                              {"spine_5", "seventh thoracic vertebra"},
                                                              {"neck_1", "seventh cervical vertebra"},
                                                              {"neck_2", "fourth cervical vertebra"}}};
    for (const auto& [joint, vertebra] : disks)
        points[joint] = middle(bones.part(std::string("intervertebral disk of ") + vertebra).vertices);
    const Points& atlas = bones.part("atlas").vertices;
    points["head"] = {0.0, atlas.col(1).maxCoeff(), 0.5 * (atlas.col(2).minCoeff() + atlas.col(2).maxCoeff())};
    const Points& mandible = bones.part("mandible").vertices;
    const Eigen::Vector3d back_up(0, 1, -0.6);
    Points left_half = near(mandible, {0.05, mandible.col(1).maxCoeff(), mandible.col(2).minCoeff()}, 0.04);
    Points right_half = near(mandible, {-0.05, mandible.col(1).maxCoeff(), mandible.col(2).minCoeff()}, 0.04);
    points["jaw"] = 0.5 * (end_centre(left_half, back_up, 0.006) + end_centre(right_half, back_up, 0.006));
    for (const auto& [side, lateral] : {std::pair<std::string, double>("left", 1.0), {"right", -1.0}}) {
        add_arm(bones, side, lateral, points);
        add_leg(bones, side, lateral, points);
        const Points& cheek = bones.part(side + " zygomatic bone").vertices;
        const Points& nose = bones.part(side + " lacrimal bone").vertices;
        // The orbit lies between the lacrimal bone and the frontal process of the cheek bone.
        points[side + "_orbit"] = {0.5 * (lateral * (lateral * nose.col(0)).maxCoeff() + middle(cheek)[0]),
                                   middle(nose)[1], cheek.col(2).maxCoeff() - 0.012};
    }
    points["pelvis"] = 0.5 * (points["left_thigh"] + points["right_thigh"]);
    for (const char* joint :
         {"pelvis", "jaw", "spine_1", "spine_2", "spine_3", "spine_4", "spine_5", "neck_1", "neck_2"})
        points[joint][0] = 0.0;
    return points;
}

}  // namespace ndg
