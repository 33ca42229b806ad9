% What Octave makes of a MATLAB file: a line for each leaf, numbers as the bytes they are made of.
1;

function text = hex(values)
  text = reshape(num2hex(values(:)).', 1, []);
end

function walk(path, value)
  if isstruct(value)
    names = fieldnames(value);
    for k = 1:numel(names)
      walk([path '.' names{k}], value.(names{k}));
    end
  elseif iscell(value)
    for k = 1:numel(value)
      walk(sprintf('%s{%d}', path, k), value{k});
    end
  elseif ischar(value)
    printf('%s text %s\n', path, value);
  elseif iscomplex(value)
    printf('%s complex %d %d %s %s\n', path, rows(value), columns(value), hex(real(value)), hex(imag(value)));
  else
    printf('%s real %d %d %s\n', path, rows(value), columns(value), hex(value));
  end
end

data = load(argv(){1});
names = fieldnames(data);
for k = 1:numel(names)
  walk(names{k}, data.(names{k}));
end
