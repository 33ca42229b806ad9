% Each stated pole beside its nearest. A period of delay that one side has cancelled is a pole at z = 0 on the other.
more = numel(poles) - numel(stated);
stated = [stated(:); zeros(max(more, 0), 1)];
remaining = [poles(:); zeros(max(-more, 0), 1)];
found = zeros(size(stated));
for k = 1:numel(stated)
  [~, nearest] = min(abs(remaining - stated(k)));
  found(k) = remaining(nearest);
  remaining(nearest) = [];
end

% Rounding parts a double pole by the root of 1e-16 and moves its centre by 1e-16: poles that are stated within 1e-6 of each other
% are compared by their centre. So are those near z = 0, which n periods of delay leave there: rounding parts them by its n-th root.
sampled = isfield(data, 'period_s');
centre_stated = stated;
centre_found = found;
for k = 1:numel(stated)
  same = abs(stated - stated(k)) < 1e-6 * max(1, abs(stated(k)));
  if sampled && abs(stated(k)) < 1e-3
    same = same | abs(stated) < 1e-3;
  end
  centre_stated(k) = mean(stated(same));
  centre_found(k) = mean(found(same));
end
scale = max(1, abs(centre_stated));
largest_distance = max([0; abs(centre_found - centre_stated) ./ scale]);
largest_parting = max([0; abs(found - stated) ./ scale]);
fprintf('%d %s: largest distance from those stated %.1e (multiple poles by their centre; one by one %.1e)\n', ...
  numel(stated), what, largest_distance, largest_parting);
if largest_distance > 1e-9
  warning('the %s are not those stated: %.1e apart, needed 1e-9', what, largest_distance);
end
