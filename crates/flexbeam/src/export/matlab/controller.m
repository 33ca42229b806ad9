% x+ = A x + B (v, y, u_applied), (u, y_model) = C x + D (v, y). While the voltage is not limited, u_applied = u.
controller = ss(data.A, data.B, data.C, data.D, data.period_s, 'InputName', data.inputs, 'OutputName', data.outputs);
unlimited = feedback(controller, 1, 3, 1, +1);

% The plant behind its zero-order hold. Of the delay, a part of a period stays after the whole ones: within a period, first
% the voltage of the one before last still acts, then the last one.
plant_output = {[data.design.output '_rad']};
plant = ss(data.plant.A, data.plant.B, data.plant.C, data.plant.D, 'InputName', {'u_v'}, 'OutputName', plant_output);
delay_periods = data.design.delay_s / data.period_s;
if abs(delay_periods - round(delay_periods)) <= 1e-9
  delay_periods = round(delay_periods);
end
whole_periods = floor(delay_periods);
part_s = (delay_periods - whole_periods) * data.period_s;
second = c2d(plant, data.period_s - part_s, 'zoh');
if part_s > 0
  first = c2d(plant, part_s, 'zoh');
  past = whole_periods + 1;
  held = ss(second.A * first.A, [second.B, second.A * first.B], plant.C, zeros(1, 2), data.period_s);
  taken = [whole_periods; past];
else
  past = whole_periods;
  held = second;
  taken = past;
end

% The voltages of the past, and those of them that act.
if past > 0
  shift = diag(ones(1, past), -1);
  voltages = eye(past + 1);
  voltages = voltages(taken + 1, :);
  held = held * ss(shift(2:end, 2:end), shift(2:end, 1), voltages(:, 2:end), voltages(:, 1), data.period_s);
end

% The filter of the measurement.
share = data.design.low_pass;
if share < 1
  seen = ss(1 - share, share, 1 - share, share, data.period_s) * held;
else
  seen = held;
end

% From the reference v to the voltage u and the model's tip angle y_model; the plant's own, seen through the filter, is
% seen * closed_loop(1, 1).
closed_loop = feedback(unlimited, seen, 2, 1, +1);
closed_loop = closed_loop(:, 1);

% The poles of what the feedback moves, without those that only the reference reaches.
poles = pole(feedback(sminreal(unlimited(1, 2)), seen, +1));
stated = data.certificate.sampled.closed_loop_poles;
what = 'closed-loop poles';

