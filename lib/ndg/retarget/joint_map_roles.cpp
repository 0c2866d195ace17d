// SPDX-License-Identifier: Apache-2.0
#include "ndg/retarget/joint_map_roles.h"

#include <algorithm>

namespace ndg {

namespace {

double name_score(const Role& role, const JointName& name)
{
    for (const char* word :
         {"finger", "thumb", "index", "pinky", "metacarpal", "twist", "roll", "end", "nub", "site"}) {
        if (name.has(word)) return -4.0;
    }
    const auto has = [&](const std::string& word) { return name.has(word); };
    if (std::any_of(role.words.begin(), role.words.end(), has)) return 3.0;
    if (std::any_of(role.foreign_words.begin(), role.foreign_words.end(), has)) return -3.0;
    if (std::any_of(role.weak_words.begin(), role.weak_words.end(), has)) return 1.0;
    return 0.0;
}

/// The best assignment of roles to joints of a chain in their order, all combinations tried; -1 where a role stays
/// open. Names count more than places, the first of equals wins.
class RoleFinder {
public:
    RoleFinder(const std::vector<Role>& roles, const std::vector<int>& chain, const std::vector<double>& places,
               const std::vector<JointName>& names)
        : roles_(roles), chain_(chain), places_(places), names_(names), current_(roles.size(), -1)
    {
        search(0, 0, 0.0);
    }
    /// Joints of the source, one a role; empty where a role that is not optional finds none.
    const std::vector<int>& best() const { return best_; }

private:
    void search(std::size_t role, std::size_t from, double score)
    {
        if (role == roles_.size()) {
            if (best_.empty() || score > best_score_) {
                best_ = current_;
                best_score_ = score;
            }
            return;
        }
        constexpr double tolerance = 0.05, worst = 4.0, found = 1.0, continued = 2.0;
        for (std::size_t i = from; i < chain_.size(); ++i) {
            const double off = (places_[i] - roles_[role].place) / tolerance;
            const JointName& name = names_[std::size_t(chain_[i])];
            double gain = found + name_score(roles_[role], name) - std::min(worst, off * off);
            // The second of lowerarm01 and lowerarm02 only goes on where the first began.
            if (i > 0 && !name.joined.empty() && name.joined == names_[std::size_t(chain_[i - 1])].joined &&
                name_score(roles_[role], name) > 0.0) {
                gain -= continued;
            }
            current_[role] = chain_[i];
            search(role + 1, i + 1, score + gain);
        }
        current_[role] = -1;
        if (roles_[role].optional) search(role + 1, from, score);
    }

    const std::vector<Role>& roles_;
    const std::vector<int>& chain_;
    const std::vector<double>& places_;
    const std::vector<JointName>& names_;
    std::vector<int> current_, best_;
    double best_score_ = 0.0;
};

}  // namespace

const std::vector<Role>& arm_roles()
{
    static const std::vector<Role> roles = {
        {"clavicle", 0.03, {"clavicle", "collar"}, {"shoulder"}, {"arm"}, true},
        {"upper_arm",
         0.129,
         {"upperarm", "uparm", "humerus", "shldr"},
         {"shoulder", "arm"},
         {"fore", "lower", "elbow"}},
        {"forearm", 0.315, {"forearm", "lowerarm", "lowarm", "loarm", "elbow", "radius", "ulna"}, {"arm"}, {"up"}},
        {"hand", 0.461, {"hand", "wrist"}, {}, {"arm"}, true}};
    return roles;
}

const std::vector<Role>& leg_roles()
{
    static const std::vector<Role> roles = {
        {"thigh", 0.53, {"thigh", "upleg", "upperleg", "femur"}, {"hip", "leg"}, {"low", "buttock", "knee"}},
        {"shin",
         0.285,
         {"shin", "calf", "knee", "lowerleg", "lowleg", "loleg", "tibia"},
         {"leg"},
         {"up", "thigh", "hip"}},
        {"foot", 0.045, {"foot", "ankle"}, {}, {"leg"}},
        {"toes", 0.01, {"toe", "ball"}, {}, {}, true}};
    return roles;
}

std::vector<int> find_roles(const std::vector<Role>& roles, const std::vector<int>& chain,
                            const std::vector<double>& places, const std::vector<JointName>& names)
{
    return RoleFinder(roles, chain, places, names).best();
}

}  // namespace ndg
