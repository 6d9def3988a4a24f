// The recursion in C++, by hand and with Eigen, for refbench: a line on stdin names it, seconds a sample and parameters answer.
#include <Eigen/Dense>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

static const double H = 0.05, LAMBDA = 1.5, P0 = 1e6;

// Time that this program had a processor, s.
static double processor() {
    timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return time.tv_sec + 1e-9 * time.tv_nsec;
}

static std::vector<double> read(const std::string& path, size_t most) {
    std::ifstream file(path, std::ios::binary);
    std::vector<double> values(most);
    file.read(reinterpret_cast<char*>(values.data()), most * sizeof(double));
    values.resize(file.gcount() / sizeof(double));
    return values;
}

// The textbook recursion with a full P, written out.
static void scalar(const std::vector<double>& heading, const std::vector<double>& rudder, double theta[3]) {
    const double x = LAMBDA * H, e = std::exp(-x), c = x * e, b1 = 1 - e, b0 = 1 - e - c;
    double P[3][3] = {{P0, 0, 0}, {0, P0, 0}, {0, 0, P0}};
    double u = -heading[0], v = 0, q1 = 0, q0 = 0;
    theta[0] = theta[1] = theta[2] = 0;
    for (size_t k = 0; k < heading.size(); ++k) {
        if (k > 0) {
            v = e * v - c * u;
            u = e * u - (heading[k] - heading[k - 1]);
            q0 = e * q0 + c * q1 + b0 * rudder[k - 1];
            q1 = e * q1 + b1 * rudder[k - 1];
        }
        const double y = -LAMBDA * LAMBDA * (u + v);
        const double phi[3] = {LAMBDA * v, q0, 1};
        double g[3], d = 1, error = y;
        for (int i = 0; i < 3; ++i) g[i] = P[i][0] * phi[0] + P[i][1] * phi[1] + P[i][2] * phi[2];
        for (int i = 0; i < 3; ++i) d += phi[i] * g[i];
        for (int i = 0; i < 3; ++i) error -= phi[i] * theta[i];
        for (int i = 0; i < 3; ++i) {
            const double gain = g[i] / d;
            theta[i] += gain * error;
            for (int j = 0; j < 3; ++j) P[i][j] -= gain * g[j];
        }
    }
}

static void eigen(const std::vector<double>& heading, const std::vector<double>& rudder, double out[3]) {
    const double x = LAMBDA * H, e = std::exp(-x), c = x * e;
    Eigen::Matrix2d A, Aq;
    A << e, 0, -c, e;
    Aq << e, 0, c, e;
    const Eigen::Vector2d Bq(1 - e, 1 - e - c);
    Eigen::Vector2d state(-heading[0], 0), q(0, 0);
    Eigen::Matrix3d P = P0 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d theta = Eigen::Vector3d::Zero();
    const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
    for (size_t k = 0; k < heading.size(); ++k) {
        if (k > 0) {
            state = A * state - Eigen::Vector2d(heading[k] - heading[k - 1], 0);
            q = Aq * q + Bq * rudder[k - 1];
        }
        const Eigen::Vector3d phi(LAMBDA * state(1), q(1), 1);
        const Eigen::Vector3d K = P * phi / (1 + phi.dot(P * phi));
        theta += K * (-LAMBDA * LAMBDA * state.sum() - phi.dot(theta));
        P = (I - K * phi.transpose()) * P;
    }
    for (int i = 0; i < 3; ++i) out[i] = theta(i);
}

int main(int, char** argv) {
    const std::string folder = argv[1];
    const auto heading = read(folder + "/heading_long", 20000), rudder = read(folder + "/rudder_long", 20000);
    std::string work;
    while (std::getline(std::cin, work)) {
        double theta[3], least = 1e300;
        for (int repeat = 0; repeat < 5; ++repeat) {
            const double begin = processor();
            work == "online C++ by hand" ? scalar(heading, rudder, theta) : eigen(heading, rudder, theta);
            least = std::min(least, processor() - begin);
        }
        std::printf("%.9e %.12e %.12e %.12e\n", least / heading.size(), theta[0], theta[1], theta[2]);
        std::fflush(stdout);
    }
}
