// SPDX-License-Identifier: Apache-2.0
#include "ndg/bones/bone_names.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <sstream>
#include <vector>

namespace ndg {

namespace {

using Words = std::vector<std::string>;

constexpr std::array<const char*, 12> ordinals = {"first",   "second", "third", "fourth", "fifth",    "sixth",
                                                  "seventh", "eighth", "ninth", "tenth",  "eleventh", "twelfth"};

/// A word of a bone's name and the joint it moves with, that of its side where there are two.
struct JointWord {
    const char* word;
    const char* joint;
    bool paired;
};
constexpr std::array<JointWord, 38> joint_words = {{
    {"sacrum", "pelvis", false},    {"coccyx", "pelvis", false}, {"hip", "pelvis", false},
    {"skull", "head", false},       {"frontal", "head", false},  {"parietal", "head", false},
    {"occipital", "head", false},   {"temporal", "head", false}, {"sphenoid", "head", false},
    {"ethmoid", "head", false},     {"vomer", "head", false},    {"nasal", "head", false},
    {"lacrimal", "head", false},    {"maxilla", "head", false},  {"palatine", "head", false},
    {"zygomatic", "head", false},   {"mandible", "jaw", false},  {"hyoid", "neck_2", false},
    {"humerus", "upper_arm", true}, {"scaphoid", "hand", true},  {"lunate", "hand", true},
    {"triquetral", "hand", true},   {"pisiform", "hand", true},  {"trapezium", "hand", true},
    {"trapezoid", "hand", true},    {"capitate", "hand", true},  {"hamate", "hand", true},
    {"femur", "thigh", true},       {"calcaneus", "foot", true}, {"talus", "foot", true},
    {"navicular", "foot", true},    {"cuboid", "foot", true},    {"cuneiform", "foot", true},
    {"metatarsal", "foot", true},   {"sesamoid", "foot", true},  {"toe", "toes", true},
    {"metacarpal", "hand", true},   {"concha", "head", false},
}};

Words words_of(const std::string& name)
{
    std::istringstream stream(name);
    Words words;
    for (std::string word; stream >> word;) {
        for (char& c : word) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        words.push_back(word);
    }
    return words;
}

bool has(const Words& words, const std::string& word)
{
    return std::find(words.begin(), words.end(), word) != words.end();
}

/// 1 for "first" ... 12 for "twelfth", 0 where no ordinal stands.
int ordinal(const Words& words)
{
    for (std::size_t i = 0; i < ordinals.size(); ++i)
        if (has(words, ordinals[i])) return static_cast<int>(i) + 1;
    return 0;
}

/// -1 where the words name none.
int vertebra_number(const Words& words)
{
    if (has(words, "atlas")) return 23;
    if (has(words, "axis")) return 22;
    const int n = ordinal(words);
    if (has(words, "lumbar") && n >= 1 && n <= 5) return 5 - n;
    if (has(words, "thoracic") && n >= 1) return thoracic_vertebra(n);
    if (has(words, "cervical") && n >= 1 && n <= 7) return 24 - n;
    return -1;
}

/// Joint of a bone of the fingers, "" for none.
std::string finger_joint(const Words& words)
{
    const auto joint = [](const char* finger, int k) { return std::string(finger) + "_" + std::to_string(k); };
    if (has(words, "metacarpal") && has(words, "first")) return joint("thumb", 1);
    if (!has(words, "phalanx") || has(words, "toe")) return "";
    const int place = has(words, "proximal") ? 1 : has(words, "middle") && words.front() == "middle" ? 2 : 3;
    if (has(words, "thumb")) return joint("thumb", place == 1 ? 2 : 3);
    if (!has(words, "finger")) return "";
    constexpr std::array<std::array<const char*, 2>, 4> fingers = {
        {{"index", "index"}, {"ring", "ring"}, {"little", "pinky"}, {"middle", "middle"}}};
    for (const auto& [word, finger] : fingers)
        if (has(words, word)) {
            // "Middle phalanx of index finger" is of the index; "Distal phalanx of middle finger" of the middle one.
            return joint(finger, place);
        }
    return "";
}

}  // namespace

BoneName name_bone(const AnatomyPart& part, const Skeleton& skeleton)
{
    BoneName bone;
    if (skeleton.joint_names != standard_skeleton().joint_names) return bone;
    const Words words = words_of(part.name);
    if (words.empty()) return bone;
    const auto of_kind = [&](BoneKind kind, int number = -1) {
        bone.kind = kind;
        bone.number = number;
        return bone;
    };
    const auto with_joint = [&](const std::string& joint) {
        bone.kind = BoneKind::joint;
        bone.joint = skeleton.joint(joint);
        return bone;
    };
    const int vertebra = vertebra_number(words);
    if (has(words, "disk")) return vertebra >= 0 ? of_kind(BoneKind::disk, vertebra) : bone;
    if (vertebra >= 0) return of_kind(BoneKind::vertebra, vertebra);
    if (has(words, "sternum") || has(words, "manubrium") || has(words, "xiphoid")) return of_kind(BoneKind::sternum);

    if (part.side == BodySide::middle) {
        for (const JointWord& row : joint_words)
            if (!row.paired && has(words, row.word)) return with_joint(row.joint);
        return bone;
    }
    const std::string side = part.side == BodySide::left ? "left_" : "right_";
    const int number = ordinal(words);
    if (has(words, "cartilage")) return number > 0 ? of_kind(BoneKind::cartilage, number) : bone;
    if (has(words, "rib")) return number > 0 ? of_kind(BoneKind::rib, number) : bone;
    constexpr std::array<std::pair<const char*, BoneKind>, 7> kinds = {{{"clavicle", BoneKind::clavicle},
                                                                        {"scapula", BoneKind::scapula},
                                                                        {"radius", BoneKind::radius},
                                                                        {"ulna", BoneKind::ulna},
                                                                        {"tibia", BoneKind::shank},
                                                                        {"fibula", BoneKind::shank},
                                                                        {"patella", BoneKind::patella}}};
    for (const auto& [word, kind] : kinds)
        if (has(words, word)) return of_kind(kind);
    if (const std::string joint = finger_joint(words); !joint.empty()) return with_joint(side + joint);
    for (const JointWord& row : joint_words)
        if (has(words, row.word)) return with_joint((row.paired ? side : "") + row.joint);
    return bone;
}

}  // namespace ndg
