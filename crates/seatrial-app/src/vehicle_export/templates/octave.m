@HEADER@
1;  % a script of functions: source("vehicle.m") in Octave; in Matlab and Simulink keep each function in a file of its own

function p = vehicle_parameters()
  p.thrust = [@THRUST@];                 % fraction of full
  p.speed_m_s = [@SPEED@];               % steady, at that thrust
  p.a22_per_s = [@A22@];
  p.b2_per_s2 = [@B2@];                  % per rad of rudder
  p.c0_rad_per_s2 = [@C0@];
  p.rudder_limit_rad = @LIMIT@;
  p.rudder_lag_s = @LAG@;
  p.rudder_delay_s = @DELAY@;
  p.rudder_rate_rad_s = @RATE@;
  p.surge_time_constant_s = @SURGE_T@;
  p.drag_length_m = @DRAG@;              % []: the speed follows with the time constant
  p.turning_drag_m = @TURNING@;
end

% Linear between the points; beyond them the nearest one times a power of the ratio.
function y = vehicle_scaled(x, at, values, power)
  nearest = min(max(x, at(1)), at(end));
  below = min(sum(at <= nearest), numel(at) - 1);
  if below < 1
    y = values;
  else
    share = (nearest - at(below)) / (at(below + 1) - at(below));
    y = values(below) + share * (values(below + 1) - values(below));
  end
  y = y * (x / nearest) ^ power;
end

% The derivative of [north; east; heading; speed; yaw rate; rudder]. The dead time of the rudder is not in it: pass the
% command of p.rudder_delay_s ago.
function dx = vehicle_derivative(p, x, rudder_command_rad, thrust)
  heading = x(3); speed = x(4); rate = x(5); rudder = x(6);
  command = min(max(rudder_command_rad, -p.rudder_limit_rad), p.rudder_limit_rad);
  if p.rudder_lag_s > 0
    rudder_rate = (command - rudder) / p.rudder_lag_s;
    rudder_rate = min(max(rudder_rate, -p.rudder_rate_rad_s), p.rudder_rate_rad_s);
  else
    rudder = command;
    rudder_rate = 0;
  end
  target = vehicle_scaled(thrust, p.thrust, p.speed_m_s, 1);
  if isempty(p.drag_length_m)
    acceleration = (target - speed) / p.surge_time_constant_s;
  else
    acceleration = (target * abs(target) - speed * abs(speed)) / p.drag_length_m ...
                   - p.turning_drag_m * rate ^ 2 * sign(speed);
  end
  a22 = vehicle_scaled(speed, p.speed_m_s, p.a22_per_s, 1);
  b2 = vehicle_scaled(speed ^ 2, p.speed_m_s .^ 2, p.b2_per_s2, 1);
  c0 = vehicle_scaled(speed, p.speed_m_s, p.c0_rad_per_s2, 2);
  dx = [speed * cos(heading); speed * sin(heading); rate; acceleration; a22 * rate + b2 * rudder + c0; rudder_rate];
end

% Straight ahead at a thrust.
function x = vehicle_start(p, thrust, heading_rad)
  speed = vehicle_scaled(thrust, p.thrust, p.speed_m_s, 1);
  b2 = vehicle_scaled(speed ^ 2, p.speed_m_s .^ 2, p.b2_per_s2, 1);
  c0 = vehicle_scaled(speed, p.speed_m_s, p.c0_rad_per_s2, 2);
  x = [0; 0; heading_rad; speed; 0; -c0 / b2];
end

% The state at each of the times (a column, evenly spaced), with the rudder commanded and the thrust from each of them on: one row a time.
function states = vehicle_run(p, times_s, rudder_command_rad, thrust, heading_rad)
  interval_s = times_s(2) - times_s(1);
  count = max(1, ceil(interval_s / 0.025));
  h = interval_s / count;
  x = vehicle_start(p, thrust(1), heading_rad);
  straight = x(6);
  states = zeros(numel(times_s), 6);
  for k = 1:numel(times_s)
    states(k, :) = x';
    for i = 1:count
      sent_s = times_s(k) + (i - 0.5) * h - p.rudder_delay_s;
      last = floor((sent_s - times_s(1)) / interval_s + 1e-9) + 1;
      if last < 1
        command = straight;
      else
        command = rudder_command_rad(last);
      end
      k1 = vehicle_derivative(p, x, command, thrust(k));
      k2 = vehicle_derivative(p, x + 0.5 * h * k1, command, thrust(k));
      k3 = vehicle_derivative(p, x + 0.5 * h * k2, command, thrust(k));
      k4 = vehicle_derivative(p, x + h * k3, command, thrust(k));
      x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    end
  end
end
