% x' or x(k+1) = A x + B u, y = C x + D u.
if isfield(data, 'period_s')
  model = ss(data.A, data.B, data.C, data.D, data.period_s, 'InputName', data.inputs, 'OutputName', data.outputs);
else
  model = ss(data.A, data.B, data.C, data.D, 'InputName', data.inputs, 'OutputName', data.outputs);
end
if isfield(data, 'continuous')
  continuous = ss(data.continuous.A, data.continuous.B, data.continuous.C, data.continuous.D, ...
    'InputName', data.inputs, 'OutputName', data.outputs);
end
poles = pole(model);
stated = data.poles;
what = 'poles';

