% flexbeam script: loads the .mat file of its own name beside it and rebuilds what is in it with the control package.
% For MATLAB with the Control System Toolbox, and for Octave with its package control.
if exist('OCTAVE_VERSION', 'builtin')
  pkg('load', 'control');
end
[folder, own_name] = fileparts(mfilename('fullpath'));
data = load(fullfile(folder, [own_name '.mat']));

